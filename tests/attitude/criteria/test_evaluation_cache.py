"""Cache of the designs of the previous batch."""

import dataclasses

import numpy as np
from mgeo_attitude import AttitudeManeuverProblem, Scenario, evaluate
from mgeo_attitude.criteria.evaluation_cache import EvaluationCache
from mgeo_attitude.scenario import Wheels


def test_only_new_designs_are_evaluated():
    runs = []

    def run(designs):
        runs.extend(designs[:, 0].tolist())
        return designs * 10.0

    cache = EvaluationCache()
    for batch, evaluated in [
        ([1, 2, 3], [1, 2, 3]),
        ([3, 4, 1], [4]),
        ([2, 4], [2]),  # Design 2 is not in the previous batch.
        ([4, 2], []),
        ([], []),
        ([4], [4]),
    ]:
        designs = np.array(batch, dtype=float).reshape(-1, 1)
        np.testing.assert_array_equal(cache.evaluate(designs, run), 10.0 * designs)
        assert runs == evaluated
        runs.clear()


def test_cached_values_with_constraints_equal_evaluated_values(monkeypatch):
    counts = []

    def counted(model, X, *args, **kwargs):
        counts.append(len(X))
        return evaluate(model, X, *args, **kwargs)

    monkeypatch.setattr("mgeo_attitude.problem.evaluate", counted)
    wheels = Wheels(inertia=(0.02, 0.03, 0.04), max_momentum=5e-4)
    scenario = dataclasses.replace(Scenario.paper(), wheels=wheels)
    one, other = (AttitudeManeuverProblem(scenario) for _ in range(2))
    X = np.random.default_rng(0).uniform(one.xl, one.xu, (6, 12))
    one.evaluate(X[:4])
    values = one.evaluate(X[::-1], return_as_dictionary=True)
    separate = other.evaluate(X[::-1], return_as_dictionary=True)
    assert counts == [4, 2, 6]
    np.testing.assert_array_equal(values["F"], separate["F"])
    np.testing.assert_array_equal(values["G"], separate["G"])
    assert values["G"].shape == (6, 1)
