import numpy as np
import pytest
from pymoo.core.problem import Problem

from mgeo.runs.hypervolume import compute_hypervolume


class ScaledProblem(Problem):
    def __init__(self, n_obj):
        super().__init__(n_var=1, n_obj=n_obj, xl=0, xu=1)

    def map_to_indicator_space(self, F):
        return np.asarray(F) / ([10.0, 100.0] if self.n_obj == 2 else 1.0)


def test_hypervolume_equals_area_in_indicator_space():
    # (0.2, 0.5) dominates 0.8 x 0.5 up to (1, 1), (0.6, 0.1) adds 0.4 x 0.4; (1.5, 0) is outside.
    value = compute_hypervolume(ScaledProblem(2), [[2.0, 50.0], [6.0, 10.0], [15.0, 0.0]])
    assert value == pytest.approx(0.8 * 0.5 + 0.4 * 0.4)
    assert compute_hypervolume(ScaledProblem(2), np.empty((0, 2))) == 0


@pytest.mark.parametrize("n_obj", [1, 6])
def test_hypervolume_of_one_or_six_objectives_is_none(n_obj):
    assert compute_hypervolume(ScaledProblem(n_obj), np.zeros((1, n_obj))) is None


def test_hypervolume_without_indicator_space_is_none():
    problem = Problem(n_var=1, n_obj=2, xl=0, xu=1)
    assert compute_hypervolume(problem, np.zeros((1, 2))) is None
