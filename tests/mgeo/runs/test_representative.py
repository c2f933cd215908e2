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


class Plain(Problem):
    def __init__(self, n_obj=2):
        super().__init__(n_var=1, n_obj=n_obj, xl=0, xu=1)


class Logarithmic(Plain):
    def map_to_indicator_space(self, F):
        return np.log10(np.asarray(F))


def circle(n):
    """A convex front bulging toward the origin, from (0, 1) to (1, 0)."""
    angle = np.linspace(0, np.pi / 2, n)
    return 1 - np.column_stack([np.cos(angle), np.sin(angle)])


def test_of_a_quarter_circle_the_extremes_the_knee_and_two_between_are_shown():
    F = circle(101)[::-1]  # from (1, 0) to (0, 1)
    chosen = select_representative_solutions(Plain(), F, ("a", "b"))
    assert [h.label for h in chosen] == ["best a", "between", "knee", "between", "best b"]
    assert [h.row for h in chosen] == [100, 75, 50, 25, 0]


def test_the_knee_is_sought_in_the_problems_indicator_space():
    # straight in logarithms but for one point, which a linear scale would not pick
    F = np.array([[1.0, 1000.0], [10.0, 100.0], [300.0, 2.0], [1000.0, 1.0]])
    labels = {h.row: h.label for h in select_representative_solutions(Logarithmic(), F, ("a", "b"))}
    assert labels[2] == "knee"
    linear = {h.row: h.label for h in select_representative_solutions(Plain(), F, ("a", "b"))}
    assert linear[1] == "knee"


@pytest.mark.parametrize("bulge", [0.0, 0.2])
def test_straight_and_concave_fronts_have_no_knee(bulge):
    x = np.linspace(0, 1, 11)
    F = np.column_stack([x, 1 - x + bulge * np.sin(np.pi * x)])
    assert find_knee(F) is None
    labels = [h.label for h in select_representative_solutions(Plain(), F, ("a", "b"))]
    assert labels == ["best a", "between", "between", "between", "best b"]


@pytest.mark.parametrize("seed", range(5))
def test_of_two_objectives_the_knee_is_farthest_below_the_line(seed):
    rng = np.random.default_rng(seed)
    points = np.column_stack([np.sort(rng.random(30)), -np.sort(-rng.random(30))])
    a, b = points[0], points[-1]
    # height of the line over each point: the same order as the distance to the line
    heights = a[1] + (points[:, 0] - a[0]) * (b[1] - a[1]) / (b[0] - a[0]) - points[:, 1]
    assert (find_knee(points) or 0) == np.argmax(heights)  # one of five bends outward only


def test_in_three_objectives_the_knee_is_farthest_from_the_plane():
    rng = np.random.default_rng(1)
    directions = np.abs(rng.normal(size=(200, 3)))
    sphere = 1 - directions / np.linalg.norm(directions, axis=1)[:, None]
    F = np.vstack([1 - np.eye(3), sphere])
    # the corners 1 - e_i span the plane sum = 2, so the farthest point has the least sum
    assert find_knee(F) == np.argmin(F.sum(axis=1))
    chosen = select_representative_solutions(Plain(3), F, ("a", "b", "c"))
    assert len(chosen) == 5
    assert {0, 1, 2} <= {find_extremes(F)[i] for i in range(3)} | {h.row for h in chosen}


def test_what_is_shown_unasked_is_the_knee_or_the_best_of_the_first():
    F = circle(101)
    assert select_default_solution(Plain(), F) == RepresentativeSolution(50, "knee")
    straight = np.array([[2.0, 0.0], [0.0, 2.0], [1.0, 1.0]])
    shown = select_default_solution(Plain(), straight)
    assert shown == RepresentativeSolution(1, "best of the first objective")
    assert select_default_solution(Plain(1), [[3.0]]).row == 0
