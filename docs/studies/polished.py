"""Gain of hypervolume by local refinement in each part of the front, for the paper's satellite.

``python docs/studies/polished.py ALGORITHM SEED`` makes a search of 20,000 evaluations, as in
held-out.toml, refines its front, and adds both results to data/polished.csv. ``python
docs/studies/polished.py`` prints the means. As in ``mgeo solve``, the front of NSGA-II is its last
population.
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


def measure_run(name, seed):
    """Return a row for the search and a row for the refinement of a run.

    A row contains the hypervolume by parts of the front, the CPU time, and the numbers of evaluated
    plans: complete evaluations, and evaluations at a single time with fewer samples, mostly for
    gradients.
    """
    study = read_study(HERE / "held-out.toml")
    plans, rows, spent = Counter(), [], time.process_time()

    def count_designs(kind, method):
        def counting_method(self, designs, *args, **kwargs):
            plans[kind] += len(designs)
            return method(self, designs, *args, **kwargs)

        return counting_method

    def build_row(stage, F):
        space = build_indicator_space(run.problem, [F], parts=study.problems[0].parts)
        parts = {
            part.name: part.evaluate(space(F), space) for part in build_part_indicators(space, "")
        }
        cpu = time.process_time() - spent
        return {"algorithm": name, "seed": seed, "stage": stage, **parts, **plans, "cpu_s": cpu}

    def record_search(state):
        if state.refinement is None and state.n_evaluations >= study.evaluations:
            rows[:] = [build_row("search", state.build_front()[1])]

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
            count = count_designs(kind, getattr(owner, method))
            patched.enter_context(patch.object(owner, method, count))
        outcome = run.solve(record_search)
    return [*rows, build_row("polish", outcome.F)]


def main(*given):
    if given:
        existing = pd.read_csv(DATA) if DATA.exists() else pd.DataFrame()
        table = pd.concat([existing, pd.DataFrame(measure_run(given[0], int(given[1])))])
        table.to_csv(DATA, index=False, lineterminator="\n", float_format="%.6g")
        return
    rows = pd.read_csv(DATA).drop(columns="seed")
    print(rows.groupby(["algorithm", "stage"]).mean().round(4).to_string())


if __name__ == "__main__":
    main(*sys.argv[1:])
