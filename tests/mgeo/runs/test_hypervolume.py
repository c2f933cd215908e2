import numpy as np
import pytest
from pymoo.core.population import Population
from pymoo.core.problem import Problem

from mgeo.runs.meters import HypervolumeMeter, scaled


class Plain(Problem):
    def __init__(self, n_obj):
        super().__init__(n_var=1, n_obj=n_obj, xl=0, xu=1)


class WithSpace(Plain):
    def indicator_space(self, F):
        return np.asarray(F) / [10.0, 100.0]


def population(F, G=None):
    F = np.asarray(F, dtype=float)
    evaluated = Population.new("X", np.zeros((len(F), 1)), "F", F)
    if G is not None:
        evaluated.set("G", np.asarray(G, dtype=float))
    return evaluated


def test_it_is_the_area_in_the_problems_indicator_space():
    # (0.2, 0.5) dominates 0.8 x 0.5 below (1, 1), (0.6, 0.1) adds 0.4 x 0.4; (1.5, 0) is outside
    measured = HypervolumeMeter(WithSpace(2))([[2.0, 50.0], [6.0, 10.0], [15.0, 0.0]])
    assert measured.value == pytest.approx(0.8 * 0.5 + 0.4 * 0.4)
    assert (measured.space, measured.ideal) == ("problem", ())


def test_without_indicator_space_it_is_scaled_by_what_the_run_saw():
    meter = HypervolumeMeter(Plain(2))
    meter.see(population([[0.0, 40.0], [np.nan, -9.0]]))
    meter.see(population([[10.0, 20.0], [-99.0, np.inf]]))
    measured = meter([[5.0, 30.0]])
    assert measured.value == pytest.approx(0.25)
    assert measured.space == "seen"
    assert (measured.ideal, measured.nadir) == ((0.0, 20.0), (10.0, 40.0))


def test_infeasible_solutions_do_not_widen_the_range():
    meter = HypervolumeMeter(Plain(2))
    F = [[1.0, 1.0], [3.0, 2.0], [100.0, -100.0]]
    meter.see(population(F, G=[[0.0], [-1.0], [2.0]]))
    measured = meter([[2.0, 1.0]])
    assert (measured.ideal, measured.nadir) == ((1.0, 1.0), (3.0, 2.0))


def test_an_empty_front_has_none():
    assert HypervolumeMeter(Plain(2))(np.empty((0, 2))).value == 0
    assert HypervolumeMeter(WithSpace(2))(np.empty((0, 2))).value == 0


@pytest.mark.parametrize("n_obj", [1, 6])
def test_it_is_left_out_where_it_says_nothing_or_takes_long(n_obj):
    assert HypervolumeMeter(Plain(n_obj))(np.zeros((1, n_obj))) is None


def test_scaling_keeps_an_objective_without_extent_finite():
    F = np.array([[1.0, 7.0], [3.0, 7.0]])
    assert scaled(F, F.min(axis=0), F.max(axis=0)).tolist() == [[0.0, 0.0], [1.0, 0.0]]
