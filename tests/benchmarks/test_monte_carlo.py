"""Time of a filter step in Monte Carlo runs, compared with nominal evaluations."""

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, evaluate
from mgeo_attitude.criteria.robustness import evaluate_runs
from pymoo.optimize import minimize

from mgeo import MGEODirected

from ..three import three
from .measure import time_interleaved

N_RUNS = 16
GENERATIONS = slice(100, 120)  # generations of an advanced search


class RecordingProblem(AttitudeManeuverProblem):
    """Problem that stores the designs of each generation."""

    def _evaluate(self, X, out, *args, **kwargs):
        self.generations.append(X.copy())
        super()._evaluate(X, out, *args, **kwargs)


@pytest.fixture(scope="module", params=["paper", "cubesat_6u"])
def search(request):
    """Problem with Monte Carlo runs, and generations of 48 designs from a nominal search."""
    scenario = three(request.param)
    problem = RecordingProblem(scenario)
    problem.generations = []
    budget = ("n_gen", GENERATIONS.stop)
    minimize(problem, MGEODirected(), budget, seed=1, copy_algorithm=False)
    return AttitudeManeuverProblem(scenario, n_runs=N_RUNS), problem.generations[GENERATIONS]


@pytest.mark.benchmark
@pytest.mark.parametrize("designs", [12, 48])
def test_step_of_monte_carlo_run_costs_as_much_as_nominal_step(search, designs):
    problem, generations = search
    batches, steps = [X[:designs] for X in generations], {}
    runs = [*problem.monte_carlo_runs.iterate_runs(N_RUNS)]

    def count_steps(model, evaluation):
        return evaluation.t_end[:, None] / model.step

    def run_nominal():
        steps["nominal"] = sum(evaluate(problem.model, X, 1).t_end.sum() for X in batches)

    def run_monte_carlo():
        step_counts = [evaluate_runs(runs, X, count_steps, 1, False) for X in batches]
        steps["Monte Carlo"] = problem.model.step * sum(np.sum(each) for each in step_counts)

    timings = time_interleaved({"nominal": run_nominal, "Monte Carlo": run_monte_carlo}, rounds=5)
    step_times = {name: timings[name].processor / steps[name] for name in timings}
    ratio = step_times["Monte Carlo"] / step_times["nominal"]
    print(f"\n{designs} designs: {ratio:.3f} of a nominal step")
    assert step_times["Monte Carlo"] <= 1.1 * step_times["nominal"]
