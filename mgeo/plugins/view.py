"""The presentation of solutions: a base class whose defaults serve any pymoo problem."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mgeo._typing import FloatArray
from mgeo.evaluation.individuals import as_numbers
from mgeo.plugins.protocol import ProblemMixin, ask, column_names, constraint_names, is_own

if TYPE_CHECKING:
    import pandas as pd
    import plotly.graph_objects as go
    from pymoo.core.problem import Problem

    from mgeo.plugins.shown import Review

#: Tolerance of equality constraints, as in pymoo.
TOLERANCE = 1e-4


class View:
    """Presentation of solutions of a problem; each method has a default for any problem.

    A problem with more to say returns a subclass from its method ``view(X)``. A view is built once
    for its solutions, so that an expensive evaluation can be a cached property that several
    methods use. The methods `impossible`, `facts`, `notes` and `front_summary` describe the problem
    and are also called on a view of no solutions.

    Parameters
    ----------
    problem : Problem
    X : array_like, shape (n, n_var)
        Solutions as numbers, a choice as the index of its option, or as dicts of their variables;
        n may be 0. One solution may be a row.

    Attributes
    ----------
    X : array, shape (n, n_var)
        Solutions as numbers.

    Raises
    ------
    ValueError
        If `X` has another shape.

    Examples
    --------
    >>> import pandas as pd
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import View
    >>> class Prices(View):
    ...     def describe(self):
    ...         return pd.DataFrame({"price [EUR]": 100.0 * self.X[:, 0]})
    >>> class Shop(ZDT1):
    ...     def view(self, X):
    ...         return Prices(self, X)
    >>> Shop(n_var=2).view([0.25, 0.0]).describe()
       price [EUR]
    0         25.0
    """

    def __init__(self, problem: Problem, X: ArrayLike) -> None:
        self.problem = problem
        self.X = _numbers(problem, X)

    @cached_property
    def F(self) -> FloatArray:
        """Objectives, shape (n, n_obj): those of a run where they are known, else evaluated."""
        return self._values[0]

    def take(self, rows: ArrayLike) -> View:
        """Return a view of some solutions, selected by row.

        A subclass may hand over what it has evaluated already.
        """
        places = np.asarray(rows, dtype=np.int64)
        known = self.F[places] if "F" in self.__dict__ else None
        return view_of(self.problem, self.X[places], known)

    def describe(self) -> pd.DataFrame:
        """Return a table with one row per solution, by default objectives and variables."""
        import pandas as pd

        variables, objectives = column_names(self.problem)
        return pd.DataFrame(np.hstack([self.F, self.X]), columns=[*objectives, *variables])

    def glance(self) -> pd.DataFrame:
        """Return the columns of `describe` that take milliseconds, for sliders; by default all."""
        return self.describe()

    def answers(self) -> list[str]:
        """Return a summary of each solution in one line, by default its objectives."""
        _, names = column_names(self.problem)
        return [
            ", ".join(f"{name} {value:.5g}" for name, value in zip(names, row, strict=True))
            for row in self.F.tolist()
        ]

    def limits(self) -> list[pd.DataFrame]:
        """Return for each solution a table with one row per constraint, named by the index.

        Columns are ``unit``, ``value``, ``bound`` ("at most" or "at least"), ``limit`` and
        ``margin``, which is negative where the constraint is violated. By default ``value`` and
        ``limit`` are NaN, as a pymoo problem gives margins only.
        """
        import pandas as pd

        index = pd.Index(constraint_names(self.problem), name="constraint", dtype=str)
        other = {"unit": "", "value": np.nan, "bound": "at most", "limit": np.nan}
        return [pd.DataFrame({**other, "margin": row}, index=index) for row in self.margins]

    @cached_property
    def margins(self) -> FloatArray:
        """Constraint margins, inequalities first, shape (n, n_ieq_constr + n_eq_constr)."""
        _, G, H = self._values
        return -excess(G, H)

    def arrays(self) -> dict[str, np.ndarray[Any, Any]]:
        """Return further arrays to store with a front, shape (n, ...) each, by name; here none.

        They are written into ``front.npz`` beside X, F, G and H, and read as
        ``read_run(folder).outcome.arrays``.
        """
        return {}

    def remarks(self) -> list[str]:
        """Return remarks about all solutions together, one line each; by default none."""
        return []

    def ways_out(self) -> list[str]:
        """Return suggestions where no solution satisfies all constraints; by default none."""
        return []

    def figures(self) -> dict[str, go.Figure]:
        """Return figures of all solutions together, by default ``front``, see `plain_front`.

        A report lets people click points of ``front`` whose ``customdata`` is their row.
        """
        figure = self.plain_front(type(self.problem).__name__)
        return {} if figure is None else {"front": figure}

    def plain_front(self, title: str = "") -> go.Figure | None:
        """Return the figure of a front with up to three objectives; None for more."""
        from mgeo.figures.front import MOST_OBJECTIVES, MOST_TEXTS, front_figure

        if self.problem.n_obj > MOST_OBJECTIVES:
            return None
        has_texts = is_own(self, View.describe) and len(self.X) <= MOST_TEXTS
        described = ask(self, View.describe) if has_texts else None
        return front_figure(self.X, self.F, *column_names(self.problem), title, described)

    def solution_figures(self) -> list[dict[str, go.Figure]]:
        """Return for each solution small figures, which may be animated; by default none."""
        return [{} for _ in self.X]

    def drawings(self) -> list[dict[str, dict[str, Any]]]:
        """Return `solution_figures` as dicts of ``data`` and ``layout`` with arrays.

        A subclass that makes dicts directly saves plotly's validation, nine tenths of the time.
        """
        return [
            {name: figure.to_plotly_json() for name, figure in figures.items()}
            for figures in self.solution_figures()
        ]

    def review(self) -> Review:
        """Return the only solution as a document, by default its description and constraints."""
        from mgeo.plugins.shown import Review, Section

        described, (limits,) = self.describe(), self.limits()
        facts = tuple(f"{name}: {text}" for name, text in self.facts().items())
        sections = [Section("Problem", facts)] if facts else []
        table = described.T.rename(columns={described.index[0]: "value"})
        sections.append(Section("Solution", table=table))
        if len(limits):
            sections.append(Section("Limits", table=limits))
        title, (answer,) = type(self.problem).__name__, self.answers()
        return Review(title, answer, tuple(sections))

    def impossible(self) -> list[str]:
        """Return reasons why no design satisfies the constraints, by default none."""
        return []

    def facts(self) -> dict[str, str]:
        """Return facts about the problem by name, for ``--dry-run`` and reports; default none."""
        return {}

    def notes(self) -> list[str]:
        """Return notes about the problem, for ``--dry-run``, one line each; by default none."""
        return []

    def front_summary(self, F: FloatArray) -> dict[str, float]:
        """Return numbers about a front, shape (n, n_obj), for the table of a study."""
        return {}

    @cached_property
    def _values(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """F, G and H."""
        from mgeo.algorithms.variables import designs_of  # with all algorithms

        problem = self.problem
        counts = problem.n_obj, problem.n_ieq_constr, problem.n_eq_constr
        if not len(self.X):
            F, G, H = (np.empty((0, count)) for count in counts)
            return F, G, H
        found = problem.evaluate(
            designs_of(problem, self.X.copy()),
            return_values_of=["F", "G", "H"],
            return_as_dictionary=True,
        )
        F, G, H = (np.asarray(found[name], dtype=float) for name in "FGH")
        return F, G, H


def view_of(problem: Problem, X: ArrayLike | None = None, F: FloatArray | None = None) -> View:
    """Return the problem's view of solutions, by default a `View`.

    Parameters
    ----------
    problem : Problem
    X : array_like, shape (n, n_var), optional
        Default: no solutions, for what describes the problem itself.
    F : array, shape (n, n_obj), optional
        Objectives of the solutions, if they are known.

    Raises
    ------
    PluginError
        If the problem's ``view(X)`` raises.

    Examples
    --------
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import view_of
    >>> type(view_of(ZDT1(n_var=2), [[0.25, 0.0]])).__name__
    'View'
    """
    given = np.empty((0, problem.n_var)) if X is None else _numbers(problem, X)
    view = ask(problem, ProblemMixin.view, given)
    if F is not None:
        view.F = F
    return view


def front_of(view: View, title: str) -> go.Figure | None:
    """Return the problem's own ``front`` or the plain one; None without solutions."""
    if not len(view.X):
        return None
    own = ask(view, View.figures).get("front") if is_own(view, View.figures) else None
    return view.plain_front(title) if own is None else own


def excess(G: FloatArray, H: FloatArray) -> FloatArray:
    """Return constraint violations, positive where violated, shape (n, n_ieq + n_eq)."""
    return np.hstack([np.asarray(G, dtype=float), np.abs(np.asarray(H, dtype=float)) - TOLERANCE])


def _numbers(problem: Problem, X: ArrayLike) -> FloatArray:
    given = np.asarray(X)
    if given.dtype == object:
        given = as_numbers(problem, np.atleast_1d(given))
    numbers: FloatArray = np.atleast_2d(np.array(given, dtype=float))
    if numbers.ndim != 2 or numbers.shape[1] != problem.n_var:
        raise ValueError(f"X of shape {np.shape(X)}: expected (n, {problem.n_var})")
    return numbers
