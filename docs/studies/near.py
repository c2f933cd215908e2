"""How near fronts come to the limit: of three maneuvers by search alone, of more with a polish.

``python docs/studies/near.py PRESET RULE MODE SEED`` adds a row to data/near.csv, ``python
docs/studies/near.py`` prints medians.
"""

import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd

from mgeo.runs.prepare import prepare

DATA = Path(__file__).parent / "data" / "near.csv"
TIMES = (300, 500, 700, 900, 1000, 1560, 2785, 4394)

#: Maneuvers, evaluations, starts, and whether fronts are polished. The first is the default of
#: three maneuvers.
MODES = {
    "search": (3, 59_760, 0, False),
    "three": (3, 6_000, 12, True),
    "six": (6, 6_000, 12, True),
    "ten": (10, 6_000, 12, True),
}


def ratios(F, curves):
    """What the best plan over by each time knows, of the least limit until then.

    In eclipse a limit rises: less is known than before.
    """
    step, found, limit = curves.times[1], {}, np.minimum.accumulate(curves.ending)
    for at in (*TIMES, F[:, 0].max()):
        over = F[F[:, 0] <= at]
        name = "longest" if at == F[:, 0].max() else str(at)
        least = limit[round(at / step)]
        found[name] = over[:, 1].min() / least if len(over) else np.nan
    return found


def measured(preset, rule, mode, seed):
    """One row: seconds of the processors, the hypervolume, and ratios to the limit."""
    count, evaluations, starts, polish = MODES[mode]
    options = {"preset": preset, "maneuvers": {"count": count}, "convergence": {"rule": rule}}
    if rule == "trace":
        del options["convergence"]
    run = prepare(
        "attitude", options, evaluations=evaluations, seed=seed, starts=starts, polish=polish
    )
    run.problem.evaluate(run.problem.xu[None])  # tables and compiler are not counted
    wall, cpu = time.perf_counter(), time.process_time()
    found = run.solve()
    spent = {"cpu_s": time.process_time() - cpu, "wall_s": time.perf_counter() - wall}
    last = {"longest_s": found.F[:, 0].max(), "hypervolume": found.hypervolume.value}
    return spent | last | ratios(found.F, run.problem.limit_curves)


def table(rows):
    """Medians over seeds."""
    keys = ["preset", "rule", "mode"]
    return rows.drop(columns=["seed", "wall_s"]).groupby(keys).median().round(3)


def main(*given):
    if not given:
        print(table(pd.read_csv(DATA)).to_string())
        return
    preset, rule, mode, seed = given
    row = {"preset": preset, "rule": rule, "mode": mode, "seed": int(seed)}
    row |= measured(preset, rule, mode, int(seed))
    known = pd.read_csv(DATA) if DATA.exists() else pd.DataFrame()
    pd.concat([known, pd.DataFrame([row])]).to_csv(DATA, index=False, float_format="%.6g")


if __name__ == "__main__":
    main(*sys.argv[1:])
