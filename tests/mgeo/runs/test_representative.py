import numpy as np
import pytest
from pymoo.core.problem import Problem

from mgeo.runs.summary import (
    RepresentativeSolution,
    find_extremes,
    find_knee,
    select_default_solution,
    select_representative_solutions,
)


class PlainProblem(Problem):
    def __init__(self, n_obj=2):
        super().__init__(n_var=1, n_obj=n_obj, xl=0, xu=1)


class NamedProblem(PlainProblem):
    obj_names = ("life-cycle cost [EUR]", "t_end [s]")


class LogProblem(PlainProblem):
    def map_to_indicator_space(self, F):
        return np.log10(np.asarray(F))


def build_quarter_circle(n):
    """Return a convex front from (0, 1) to (1, 0) that bulges toward the origin."""
    angle = np.linspace(0, np.pi / 2, n)
    return 1 - np.column_stack([np.cos(angle), np.sin(angle)])


def test_quarter_circle_is_represented_by_extremes_knee_and_two_points():
    F = build_quarter_circle(101)[::-1]
    chosen = select_representative_solutions(PlainProblem(), F)
    assert [h.label for h in chosen] == ["min-f1", "intermediate", "knee", "intermediate", "min-f2"]
    assert [h.row for h in chosen] == [100, 75, 50, 25, 0]


def test_knee_is_computed_in_indicator_space():
    # The logarithms form a straight line except for one point, which is not the linear knee.
    F = np.array([[1.0, 1000.0], [10.0, 100.0], [300.0, 2.0], [1000.0, 1.0]])
    labels = {h.row: h.label for h in select_representative_solutions(LogProblem(), F)}
    assert labels[2] == "knee"
    linear = {h.row: h.label for h in select_representative_solutions(PlainProblem(), F)}
    assert linear[1] == "knee"


@pytest.mark.parametrize("bulge", [0.0, 0.2])
def test_straight_and_concave_fronts_have_no_knee(bulge):
    x = np.linspace(0, 1, 11)
    F = np.column_stack([x, 1 - x + bulge * np.sin(np.pi * x)])
    assert find_knee(F) is None
    labels = [h.label for h in select_representative_solutions(PlainProblem(), F)]
    assert labels == ["min-f1", "intermediate", "intermediate", "intermediate", "min-f2"]


@pytest.mark.parametrize("seed", range(5))
def test_knee_of_two_objectives_is_farthest_from_line(seed):
    rng = np.random.default_rng(seed)
    points = np.column_stack([np.sort(rng.random(30)), -np.sort(-rng.random(30))])
    a, b = points[0], points[-1]
    # The vertical distance to the line has the same order as the normal distance.
    heights = a[1] + (points[:, 0] - a[0]) * (b[1] - a[1]) / (b[0] - a[0]) - points[:, 1]
    assert (find_knee(points) or 0) == np.argmax(heights)  # One of the five fronts has no knee.


def test_knee_of_three_objectives_is_farthest_from_plane():
    rng = np.random.default_rng(1)
    directions = np.abs(rng.normal(size=(200, 3)))
    sphere = 1 - directions / np.linalg.norm(directions, axis=1)[:, None]
    F = np.vstack([1 - np.eye(3), sphere])
    # The corners 1 - e_i span the plane sum = 2, so the farthest point has the smallest sum.
    assert find_knee(F) == np.argmin(F.sum(axis=1))
    chosen = select_representative_solutions(PlainProblem(3), F)
    assert len(chosen) == 5
    assert {0, 1, 2} <= {find_extremes(F)[i] for i in range(3)} | {h.row for h in chosen}


def test_default_solution_is_knee_or_best_of_first_objective():
    F = build_quarter_circle(101)
    assert select_default_solution(PlainProblem(), F) == RepresentativeSolution(50, "knee")
    straight = np.array([[2.0, 0.0], [0.0, 2.0], [1.0, 1.0]])
    shown = select_default_solution(PlainProblem(), straight)
    assert shown == RepresentativeSolution(1, "min-f1")
    assert select_default_solution(PlainProblem(1), [[3.0]]).row == 0


def test_labels_are_names_without_units_or_those_of_the_problem():
    def labels(problem):
        chosen = select_representative_solutions(problem, [[0.0, 2.0], [2.0, 0.0]])
        return [each.label for each in chosen]

    assert labels(NamedProblem()) == ["min-life-cycle-cost", "min-t_end"]
    problem = NamedProblem()
    problem.obj_labels = ("cost", "time")
    assert labels(problem) == ["min-cost", "min-time"]
