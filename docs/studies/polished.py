"""What a polish adds to each part of the front, the paper's satellite, held-out seeds.

``python docs/studies/polished.py ALGORITHM SEED`` adds to data/polished.csv a search of 20,000
evaluations, as in held-out.toml, and its polish; ``python docs/studies/polished.py`` prints means.
What is measured and polished is what ``mgeo solve`` has: of NSGA-II its last population.
"""

import sys
import time
from collections import Counter
from contextlib import ExitStack
from pathlib import Path
from unittest.mock import patch

import pandas as pd
from mgeo_attitude import AttitudeManeuverProblem
from mgeo_attitude.refine.evaluators import FixedTimeEvaluator

from mgeo.runs.prepare import prepare_run
from mgeo.studies.indicators import build_indicator_space, build_part_indicators
from mgeo.studies.study_file import read_study

HERE = Path(__file__).parent
DATA = HERE / "data" / "polished.csv"
PARAMETERS = {"mgeo-directed": {}, "nsga2": {"population": 100}}


def measured(name, seed):
    """A row of the search and one of its polish: hypervolume by parts, plans and CPU seconds.

    Plans are those judged whole and those whose value at one time is asked, for slopes mostly and
    by fewer samples.
    """
    study = read_study(HERE / "held-out.toml")
    plans, rows, spent = Counter(), [], time.process_time()

    def counted(kind, method):
        def counting(self, designs, *args, **kwargs):
            plans[kind] += len(designs)
            return method(self, designs, *args, **kwargs)

        return counting

    def row(stage, F):
        space = build_indicator_space(run.problem, [F], parts=study.problems[0].parts)
        parts = {
            part.name: part.evaluate(space(F), space) for part in build_part_indicators(space, "")
        }
        cpu = time.process_time() - spent
        return {"algorithm": name, "seed": seed, "stage": stage, **parts, **plans, "cpu_s": cpu}

    def look(state):
        if state.refinement is None and state.n_evaluations >= study.evaluations:
            rows[:] = [row("search", state.build_front()[1])]

    run = prepare_run(
        "attitude",
        {"preset": "paper"},
        algorithm=name,
        parameters=PARAMETERS[name],
        evaluations=study.evaluations,
        seed=seed,
        refine=True,
    )
    with ExitStack() as patched:
        for kind, owner, method in (
            ("whole", AttitudeManeuverProblem, "_evaluate"),
            ("at_one_time", FixedTimeEvaluator, "evaluate_at_steps"),
        ):
            count = counted(kind, getattr(owner, method))
            patched.enter_context(patch.object(owner, method, count))
        found = run.solve(look)
    return [*rows, row("polish", found.F)]


def main(*given):
    if given:
        known = pd.read_csv(DATA) if DATA.exists() else pd.DataFrame()
        table = pd.concat([known, pd.DataFrame(measured(given[0], int(given[1])))])
        table.to_csv(DATA, index=False, lineterminator="\n", float_format="%.6g")
        return
    rows = pd.read_csv(DATA).drop(columns="seed")
    print(rows.groupby(["algorithm", "stage"]).mean().round(4).to_string())


if __name__ == "__main__":
    main(*sys.argv[1:])
