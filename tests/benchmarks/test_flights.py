"""A filter step over flights takes as long as one of plans that are flown exactly."""

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, evaluate
from mgeo_attitude.criteria.robustness import evaluate_runs
from pymoo.optimize import minimize

from mgeo import MGEODirected

from ..three import three
from .measure import interleaved

FLIGHTS = 16
GENERATIONS = slice(100, 120)  # of a search that has found its way


class Recorded(AttitudeManeuverProblem):
    """Keeps the designs of each generation."""

    def _evaluate(self, X, out, *args, **kwargs):
        self.generations.append(X.copy())
        super()._evaluate(X, out, *args, **kwargs)


@pytest.fixture(scope="module", params=["paper", "cubesat_6u"])
def search(request):
    """A problem over flights, and generations of a search of the exact one, 48 designs each."""
    scenario = three(request.param)
    exact = Recorded(scenario)
    exact.generations = []
    budget = ("n_gen", GENERATIONS.stop)
    minimize(exact, MGEODirected(), budget, seed=1, copy_algorithm=False)
    return AttitudeManeuverProblem(scenario, n_runs=FLIGHTS), exact.generations[GENERATIONS]


@pytest.mark.benchmark
@pytest.mark.parametrize("designs", [12, 48])
def test_a_step_over_flights_costs_hardly_more_than_an_exact_one(search, designs):
    problem, generations = search
    batches, steps = [X[:designs] for X in generations], {}

    def times(model, ran):
        return ran.t_end[:, None] / model.step

    def exact():
        steps["exact"] = sum(evaluate(problem.model, X, 1).t_end.sum() for X in batches)

    def flown():
        found = [evaluate_runs(problem.flights, X, times, 1, False) for X in batches]
        steps["flown"] = problem.model.step * sum(np.sum(each) for each in found)

    timings = interleaved({"exact": exact, "flown": flown}, rounds=5)
    spent = {name: timings[name].processor / steps[name] for name in timings}
    print(f"\n{designs} designs: {spent['flown'] / spent['exact']:.3f} of an exact step")
    assert spent["flown"] <= 1.1 * spent["exact"]
