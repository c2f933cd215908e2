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


class Plain(Problem):
    def __init__(self, n_obj=2):
        super().__init__(n_var=1, n_obj=n_obj, xl=0, xu=1)


class Scaled(Plain):
    def map_to_indicator_space(self, F):
        return np.log10(F)

    def view(self, X):
        return Summary(self, X)


class Summary(View):
    def front_summary(self, F):
        return {"below ten": int((F[:, 0] < 10).sum())}


def test_without_a_space_of_its_own_the_union_spans_0_to_1():
    fronts = [np.array([[0.0, 40.0], [10.0, 30.0], [99.0, 99.0]]), np.array([[20.0, 20.0]])]
    space = build_indicator_space(Plain(), fronts)
    assert space.origin == "union"
    assert space(np.array([[0.0, 20.0], [20.0, 40.0]])).tolist() == [[0, 0], [1, 1]]
    assert space.reference_point.tolist() == [1.1, 1.1]
    assert space.reference_front.tolist() == [[0.0, 1.0], [0.5, 0.5], [1.0, 0.0]]
    # (0, 1), (0.5, 0.5) and (1, 0) below (1.1, 1.1), worked by hand
    union = np.concatenate(fronts)
    assert HV.evaluate(space(union), space) == pytest.approx(1.1 * 0.1 + 0.6 * 0.5 + 0.1 * 0.5)
    assert (IGD.evaluate(space(union), space), EPS.evaluate(space(union), space)) == (0, 0)


def test_the_hypervolume_by_parts_is_worked_by_hand_and_adds_up():
    fronts = [np.array([[0.0, 40.0], [10.0, 30.0], [20.0, 20.0]])]
    space = build_indicator_space(Plain(), fronts, parts=[5.0, 10.0])
    assert (space.parts, space.cuts) == ((5.0, 10.0), (0.25, 0.5))
    parts = build_part_indicators(space, "f1")
    titles = ["f1 to 5", "f1 from 5 to 10", "f1 from 10"]
    assert [part.title for part in parts] == [f"hypervolume, {title}" for title in titles]
    # (0, 1) alone below (., 1.1) up to 0.5, then (0.5, 0.5), and (1, 0) from 1 to 1.1
    values = [part.evaluate(space(fronts[0]), space) for part in parts]
    assert values == pytest.approx([0.25 * 0.1, 0.25 * 0.1, 0.5 * 0.6 + 0.1 * 1.1])
    some = space(np.array([[12.0, 25.0]]))
    assert [part.evaluate(some, space) for part in parts] == pytest.approx([0, 0, 0.5 * 0.85])
    assert [part.evaluate(some[:0], space) for part in parts] == [0, 0, 0]


@given(st.integers(2, 4), st.integers(0, 2**32 - 1))
def test_parts_add_up_to_the_whole(n_obj, seed):
    F = np.random.default_rng(seed).random((20, n_obj))
    space = build_indicator_space(Plain(n_obj), [F])
    assert np.isin(space.parts, F[:, 0]).all()
    points = space(F[:7])
    parts = [part.evaluate(points, space) for part in build_part_indicators(space, "f1")]
    assert min(parts) >= 0
    assert sum(parts) == pytest.approx(HV.evaluate(points, space))


def test_the_problems_own_space_comes_first():
    space = build_indicator_space(Scaled(), [np.array([[1.0, 1.0]])])
    assert space.origin == "problem"
    assert space(np.array([[10.0, 100.0]])).tolist() == [[1.0, 2.0]]
    assert HV.evaluate(space(np.array([[1.0, 10**0.25]])), space) == pytest.approx(0.75)


def test_a_given_pareto_front_belongs_to_the_union_and_is_the_reference():
    problem = ZDT1()
    front = problem.pareto_front()
    space = build_indicator_space(problem, [np.array([[0.5, 3.0]])], reference_front=front)
    assert (space.ideal.tolist(), space.nadir.tolist()) == ([0.0, 0.0], [1.0, 1.0])
    assert np.allclose(space.reference_front, front)
    # closed form: the area under 1.1, above f2 = 1 - sqrt(f1), is 1.1^2 - 1/3
    x = np.linspace(0, 1, 20_001)
    fine = np.column_stack([x, 1 - np.sqrt(x)])
    assert HV.evaluate(space(fine), space) == pytest.approx(1.1**2 - 1 / 3, abs=1e-4)


def test_given_bounds_and_reference_front_count():
    space = build_indicator_space(
        Scaled(), [np.array([[1.0, 1.0]])], bounds=([0, 0], [2, 4]), reference_front=[[1.0, 1.0]]
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
def test_unusable_spaces_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        build_indicator_space(Plain(), [np.ones((1, 2))], **options)


def test_without_any_front_there_is_no_space():
    with pytest.raises(NoFeasibleSolutionError, match="no run found a feasible solution"):
        build_indicator_space(Plain(), [np.empty((0, 2))])


def test_a_crowded_stretch_does_not_dominate_the_reference():
    # 9000 points on the first tenth of a line, 900 on the rest
    x = np.concatenate([np.linspace(0, 0.1, 9000), np.linspace(0.1005, 1, 900)])
    space = build_indicator_space(Plain(), [np.column_stack([x, 1 - x])])
    assert len(space.reference_front) == MAX_REFERENCE_POINTS
    assert np.mean(space.reference_front[:, 0] <= 0.1) < 0.2


def test_the_reference_of_three_objectives_is_evenly_spread():
    F = np.random.default_rng(1).exponential(size=(4000, 3)) ** [1, 1, 3]
    space = build_indicator_space(Plain(3), [F / F.sum(axis=1, keepdims=True)])
    reference = space.reference_front
    assert len(reference) == MAX_REFERENCE_POINTS
    near = np.sort(cdist(reference, reference), axis=1)[:, 1]
    assert near.std() < 0.2 * near.mean()  # 0.5 if drawn at random from an even front


@given(arrays(float, (5, 2), elements=unit), arrays(float, (4, 2), elements=unit))
def test_igd_plus_and_epsilon_are_what_their_definitions_say(A, R):
    space = build_indicator_space(Plain(), [R], bounds=([0, 0], [1, 1]), reference_front=R)
    gaps = A[None, :, :] - R[:, None, :]  # reference, point, objective
    plus = np.sqrt((np.maximum(gaps, 0) ** 2).sum(axis=2)).min(axis=1).mean()
    assert IGD.evaluate(A, space) == pytest.approx(plus, abs=1e-12)
    assert EPS.evaluate(A, space) == pytest.approx(gaps.max(axis=2).min(axis=1).max(), abs=1e-12)


def test_six_objectives_are_measured_without_hypervolume():
    assert [i.name for i in select_indicators(5)] == ["hypervolume", "igd_plus", "epsilon"]
    assert [i.name for i in select_indicators(6)] == ["igd_plus", "epsilon"]


def test_the_trace_follows_the_front():
    F = np.array([[50.0, 1.0], [1.0, 50.0], [1.0, 1.0]])
    record = StudyRun(np.array([2, 3, 9]), F, np.array([2]), np.ones((1, 1)), 10, 10, 0, 0.0)
    space = build_indicator_space(Scaled(), [F])
    rows = build_indicator_rows(Scaled(), record, [1, 2, 8, 9, 10], space)
    assert [row["evaluations"] for row in rows] == [1, 2, 8, 9, 10]
    assert [row["points"] for row in rows] == [0, 1, 2, 1, 1]
    assert [row["hypervolume"] for row in rows] == pytest.approx([0, 0, 0, 1, 1])
    assert [row["below ten"] for row in rows] == [0, 0, 1, 1, 1]
