"""How near fronts come to the limit: of three maneuvers by search alone, of more with a polish.

``python docs/studies/near.py PRESET RULE MODE SEED`` adds a row to data/near.csv, ``python
docs/studies/near.py`` prints medians. ``python docs/studies/near.py PRESET TIME COUNT RATE`` prints
how near the best of many plans of so many maneuvers up to a rate [deg/s] comes at a time [s], each
polished for it alone; of ten at the preset's rate, if not told.
"""

import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.refine.at_time import at_time
from mgeo_attitude.refine.descent import descend
from mgeo_attitude.refine.roughly import Roughly
from mgeo_attitude.refine.splitting import split
from mgeo_attitude.refine.starts import beam

from mgeo.runs.prepare import prepare

DATA = Path(__file__).parent / "data" / "near.csv"
#: Fronts of seed 1 by the rule "end", for the figure.
FRONTS = Path(__file__).parents[1] / "fronts" / "near.csv"
#: Ratio of times below which one of two points of a front is enough for it.
DENSE = 1.02
TIMES = (300, 500, 700, 900, 1000, 1560, 2785, 4394)

#: Maneuvers, evaluations, starts, and whether fronts are polished. The first is the default of
#: three maneuvers.
MODES = {
    "search": (3, 59_760, 0, False),
    "longer": (3, 160_000, 0, False),
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
    """Seconds of the processors, hypervolume and ratios to the limit; and the front."""
    count, evaluations, starts, polish = MODES[mode]
    options = {"preset": preset, "maneuvers": {"count": count}, "convergence": {"rule": rule}}
    run = prepare(
        "attitude", options, evaluations=evaluations, seed=seed, starts=starts, polish=polish
    )
    run.problem.evaluate(run.problem.xu[None])  # tables and compiler are not counted
    wall, cpu = time.perf_counter(), time.process_time()
    found = run.solve()
    spent = {"cpu_s": time.process_time() - cpu, "wall_s": time.perf_counter() - wall}
    last = {"longest_s": found.F[:, 0].max(), "hypervolume": found.hypervolume.value}
    return spent | last | ratios(found.F, run.problem.limit_curves), found.F


def thinned(F):
    """Points of a front for a figure."""
    rows = [0]
    for row in range(1, len(F)):
        if F[row, 0] >= DENSE * F[rows[-1], 0]:
            rows.append(row)
    return F[rows]


def best_known(preset, time, count=10, rate=None, starts=300, seed=1):
    """What the best of many plans of a time [s] knows, of the limit."""
    maneuvers = {"count": count} | ({} if rate is None else {"max_rate_deg_s": rate})
    options = {"preset": preset, "maneuvers": maneuvers, "convergence": {"rule": "end"}}
    problem = AttitudeManeuverProblem(Scenario.from_dict(options))
    exact, rng = at_time(problem), np.random.default_rng(seed)
    roughly, greatest = Roughly(exact), exact.scenario.maneuvers.max_rate_deg_s
    at, steps = roughly.at(time), roughly.steps(time)
    durations = time * rng.dirichlet(np.full(count, 3.0), starts)
    rates = rng.uniform(-greatest, greatest, (starts, count, 3))
    rates[::2] = greatest * np.sign(rates[::2])  # half of them as fast as they may be
    plans = np.concatenate([rates, durations[:, :, None]], axis=2).reshape(starts, -1)
    beams = [split(beam(at, n, time, 2, 400)[::10], count) for n in range(count // 2, count + 1)]
    plans = np.vstack([plans, *beams])
    for left, iterations in ((starts // 5, 15), (6, 30), (6, 150)):
        plans = at.best(descend(at, plans, time, iterations), steps, left)
    step = round(time / exact.model.step)
    value, _ = exact.values(descend(exact, plans, time, 30), step)
    return np.exp(value.min()) / np.minimum.accumulate(problem.limit_curves.ending)[step]


def append(file, rows):
    known = pd.read_csv(file) if file.exists() else pd.DataFrame()
    pd.concat([known, rows]).to_csv(file, index=False, float_format="%.6g")


def table(rows):
    """Medians over seeds."""
    keys = ["preset", "rule", "mode"]
    return rows.drop(columns=["seed", "wall_s"]).groupby(keys).median().round(3)


def main(*given):
    if not given:
        print(table(pd.read_csv(DATA)).to_string())
        return
    if given[1] not in ("end", "trace"):
        preset, time, *more = given
        print(best_known(preset, float(time), *map(int, more[:1]), *map(float, more[1:])))
        return
    preset, rule, mode, seed = given
    row = {"preset": preset, "rule": rule, "mode": mode, "seed": int(seed)}
    values, F = measured(preset, rule, mode, int(seed))
    append(DATA, pd.DataFrame([row | values]))
    if rule == "end" and seed == "1":
        t_end, trace = thinned(F).T
        points = {"preset": preset, "mode": mode, "t_end [s]": t_end, "trace [-]": trace}
        append(FRONTS, pd.DataFrame(points))


if __name__ == "__main__":
    main(*sys.argv[1:])
