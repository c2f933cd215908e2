"""The solution that is shown first, and the limits it exceeds although it keeps all constraints."""

import numpy as np
from pymoo.problems import get_problem

from mgeo.algorithms import MGEODirected
from mgeo.plugins.view import view_of
from mgeo.runs.answer import answer, nearest_kept
from tests.mgeo.solved import solve

from .test_limits import Heights, Told


class Nowhere(Heights):
    def limits(self):
        return [table.assign(margin=-1.0) for table in super().limits()]


class Tall(Told):
    """One whose constraints are looser than the limits it tells."""

    def __init__(self):
        super().__init__()
        self.n_eq_constr = 0

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"], out["G"] = -X.sum(axis=1), X[:, :1] - 3.0


def answered(problem):
    found = solve(problem, MGEODirected(), 400, seed=1)
    return answer(view_of(problem, found.X, found.F))


def test_a_limit_that_is_exceeded_is_told():
    found = answered(Tall())
    (exceeded,) = found.exceeded
    assert exceeded == "height: 3 m, at most 2 m: exceeded by 1 m"
    assert str(found) == f"solution 0 of 1, {found.label}: f1 -7; BUT {exceeded}"


def test_the_nearest_solution_that_keeps_all_limits_is_named():
    class Slender(Tall):
        """The taller the better, and the better the dearer: a front of heights 0 to 3."""

        def __init__(self):
            super().__init__()
            self.n_obj = 2

        def _evaluate(self, X, out, *args, **kwargs):
            out["F"] = np.column_stack([-X[:, 0], X[:, 0] ** 8 + X[:, 1]])
            out["G"] = X[:, :1] - 3.0

    problem = Slender()
    outcome = solve(problem, MGEODirected(), 400, seed=1)
    heights = outcome.X[:, 0]
    keep = np.flatnonzero(heights <= 2.0)
    assert len(keep) > 10
    view = view_of(problem, outcome.X, outcome.F)
    problem.shown = Nowhere
    shown = answer(view_of(problem, outcome.X, outcome.F))
    assert (len(shown.exceeded), shown.instead) == (1, None)
    problem.shown = Heights
    n = len(heights)
    found = [nearest_kept(view, row) for row in (0, keep[0] - 5, keep[0] + 5, n - 1)]
    assert keep[0] <= found[0] <= keep[0] + n / 33 + 1  # one of 34 that are spread evenly
    assert found[1:] == [keep[0], keep[0] + 5, n - 1]
    assert nearest_kept(view_of(get_problem("zdt1"), np.zeros((1, 30))), 0) is None  # tells of none


def test_without_one_there_is_none():
    class Short(Tall):
        def _evaluate(self, X, out, *args, **kwargs):
            out["F"], out["G"] = -X.sum(axis=1), X[:, :1] - 1.5

    for problem in (Short(), get_problem("zdt1")):
        found = answered(problem)
        assert found.exceeded == ()
        assert "BUT" not in str(found)
        assert np.isfinite(float(found.text.split()[-1]))
