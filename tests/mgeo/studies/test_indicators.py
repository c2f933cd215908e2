import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pymoo.core.problem import Problem
from pymoo.problems.multi import ZDT1
from scipy.spatial.distance import cdist

from mgeo import View
from mgeo.studies.indicators import (
    INDICATORS,
    MAX_REFERENCE_POINTS,
    NoFeasibleSolutionError,
    build_indicator_rows,
    build_indicator_space,
    build_part_indicators,
    select_indicators,
)
from mgeo.studies.study_run import StudyRun

HV, IGD, EPS = INDICATORS
unit = st.floats(0, 1, width=32)


class PlainProblem(Problem):
    def __init__(self, n_obj=2):
        super().__init__(n_var=1, n_obj=n_obj, xl=0, xu=1)


class LogProblem(PlainProblem):
    def map_to_indicator_space(self, F):
        return np.log10(F)

    def view(self, X):
        return SummaryView(self, X)


class SummaryView(View):
    def front_summary(self, F):
        return {"below ten": int((F[:, 0] < 10).sum())}


def test_default_space_scales_union_of_fronts_to_unit_range():
    fronts = [np.array([[0.0, 40.0], [10.0, 30.0], [99.0, 99.0]]), np.array([[20.0, 20.0]])]
    space = build_indicator_space(PlainProblem(), fronts)
    assert space.origin == "union"
    assert space(np.array([[0.0, 20.0], [20.0, 40.0]])).tolist() == [[0, 0], [1, 1]]
    assert space.reference_point.tolist() == [1.1, 1.1]
    assert space.reference_front.tolist() == [[0.0, 1.0], [0.5, 0.5], [1.0, 0.0]]
    # Areas that (0, 1), (0.5, 0.5) and (1, 0) dominate up to (1.1, 1.1).
    union = np.concatenate(fronts)
    assert HV.evaluate(space(union), space) == pytest.approx(1.1 * 0.1 + 0.6 * 0.5 + 0.1 * 0.5)
    assert (IGD.evaluate(space(union), space), EPS.evaluate(space(union), space)) == (0, 0)


def test_hypervolume_of_parts_equals_manual_calculation():
    fronts = [np.array([[0.0, 40.0], [10.0, 30.0], [20.0, 20.0]])]
    space = build_indicator_space(PlainProblem(), fronts, parts=[5.0, 10.0])
    assert (space.parts, space.cuts) == ((5.0, 10.0), (0.25, 0.5))
    parts = build_part_indicators(space, "f1")
    titles = ["f1 to 5", "f1 from 5 to 10", "f1 from 10"]
    assert [part.title for part in parts] == [f"hypervolume, {title}" for title in titles]
    # Only (0, 1) contributes up to f1 = 0.5, (0.5, 0.5) beyond, and (1, 0) from 1 to 1.1.
    values = [part.evaluate(space(fronts[0]), space) for part in parts]
    assert values == pytest.approx([0.25 * 0.1, 0.25 * 0.1, 0.5 * 0.6 + 0.1 * 1.1])
    some = space(np.array([[12.0, 25.0]]))
    assert [part.evaluate(some, space) for part in parts] == pytest.approx([0, 0, 0.5 * 0.85])
    assert [part.evaluate(some[:0], space) for part in parts] == [0, 0, 0]


@given(st.integers(2, 4), st.integers(0, 2**32 - 1))
def test_hypervolumes_of_parts_add_up_to_total(n_obj, seed):
    F = np.random.default_rng(seed).random((20, n_obj))
    space = build_indicator_space(PlainProblem(n_obj), [F])
    assert np.isin(space.parts, F[:, 0]).all()
    points = space(F[:7])
    parts = [part.evaluate(points, space) for part in build_part_indicators(space, "f1")]
    assert min(parts) >= 0
    assert sum(parts) == pytest.approx(HV.evaluate(points, space))


def test_indicator_space_of_problem_is_preferred():
    space = build_indicator_space(LogProblem(), [np.array([[1.0, 1.0]])])
    assert space.origin == "problem"
    assert space(np.array([[10.0, 100.0]])).tolist() == [[1.0, 2.0]]
    assert HV.evaluate(space(np.array([[1.0, 10**0.25]])), space) == pytest.approx(0.75)


def test_given_reference_front_extends_union():
    problem = ZDT1()
    front = problem.pareto_front()
    space = build_indicator_space(problem, [np.array([[0.5, 3.0]])], reference_front=front)
    assert (space.ideal.tolist(), space.nadir.tolist()) == ([0.0, 0.0], [1.0, 1.0])
    assert np.allclose(space.reference_front, front)
    # The area between f2 = 1 - sqrt(f1) and the reference point is 1.1^2 - 1/3.
    x = np.linspace(0, 1, 20_001)
    fine = np.column_stack([x, 1 - np.sqrt(x)])
    assert HV.evaluate(space(fine), space) == pytest.approx(1.1**2 - 1 / 3, abs=1e-4)


def test_given_bounds_and_reference_front_are_used():
    space = build_indicator_space(
        LogProblem(),
        [np.array([[1.0, 1.0]])],
        bounds=([0, 0], [2, 4]),
        reference_front=[[1.0, 1.0]],
    )
    assert (space.origin, space.transform) == ("given", None)
    assert space.reference_point.tolist() == [1, 1]
    assert space.reference_front.tolist() == [[0.5, 0.25]]
    assert EPS.evaluate(space(np.array([[2.0, 1.0]])), space) == 0.5
    assert IGD.evaluate(space(np.array([[2.0, 0.0]])), space) == 0.5


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"bounds": ([0, 0], [1, 0])}, "ideal < nadir"),
        ({"reference_front": [[1, 2, 3]]}, r"shape \(1, 3\): expected \(n, 2\)"),
    ],
)
def test_invalid_space_arguments_are_rejected(options, message):
    with pytest.raises(ValueError, match=message):
        build_indicator_space(PlainProblem(), [np.ones((1, 2))], **options)


def test_space_without_fronts_raises_error():
    with pytest.raises(NoFeasibleSolutionError, match="no run found a feasible solution"):
        build_indicator_space(PlainProblem(), [np.empty((0, 2))])


def test_reference_front_is_evenly_spaced():
    # The first tenth of the line has 9000 points, the rest has 900.
    x = np.concatenate([np.linspace(0, 0.1, 9000), np.linspace(0.1005, 1, 900)])
    space = build_indicator_space(PlainProblem(), [np.column_stack([x, 1 - x])])
    assert len(space.reference_front) == MAX_REFERENCE_POINTS
    assert np.mean(space.reference_front[:, 0] <= 0.1) < 0.2


def test_reference_front_of_three_objectives_is_evenly_spaced():
    F = np.random.default_rng(1).exponential(size=(4000, 3)) ** [1, 1, 3]
    space = build_indicator_space(PlainProblem(3), [F / F.sum(axis=1, keepdims=True)])
    reference = space.reference_front
    assert len(reference) == MAX_REFERENCE_POINTS
    near = np.sort(cdist(reference, reference), axis=1)[:, 1]
    assert near.std() < 0.2 * near.mean()  # A random selection would give 0.5.


@given(arrays(float, (5, 2), elements=unit), arrays(float, (4, 2), elements=unit))
def test_igd_plus_and_epsilon_equal_their_definitions(A, R):
    space = build_indicator_space(PlainProblem(), [R], bounds=([0, 0], [1, 1]), reference_front=R)
    gaps = A[None, :, :] - R[:, None, :]
    plus = np.sqrt((np.maximum(gaps, 0) ** 2).sum(axis=2)).min(axis=1).mean()
    assert IGD.evaluate(A, space) == pytest.approx(plus, abs=1e-12)
    assert EPS.evaluate(A, space) == pytest.approx(gaps.max(axis=2).min(axis=1).max(), abs=1e-12)


def test_six_objectives_have_no_hypervolume():
    assert [i.name for i in select_indicators(5)] == ["hypervolume", "igd_plus", "epsilon"]
    assert [i.name for i in select_indicators(6)] == ["igd_plus", "epsilon"]


def test_indicator_rows_follow_front_over_evaluations():
    F = np.array([[50.0, 1.0], [1.0, 50.0], [1.0, 1.0]])
    run = StudyRun(np.array([2, 3, 9]), F, np.array([2]), np.ones((1, 1)), 10, 10, 0, 0.0)
    space = build_indicator_space(LogProblem(), [F])
    rows = build_indicator_rows(LogProblem(), run, [1, 2, 8, 9, 10], space)
    assert [row["evaluations"] for row in rows] == [1, 2, 8, 9, 10]
    assert [row["points"] for row in rows] == [0, 1, 2, 1, 1]
    assert [row["hypervolume"] for row in rows] == pytest.approx([0, 0, 0, 1, 1])
    assert [row["below ten"] for row in rows] == [0, 0, 1, 1, 1]
