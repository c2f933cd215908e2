"""What people are shown of solutions: one class, which serves any pymoo problem as it stands."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Hashable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from mgeo._typing import FloatArray
from mgeo.evaluation.individuals import as_numbers
from mgeo.plugins.protocol import asked, column_names, constraint_names
from mgeo.plugins.shown import ask

if TYPE_CHECKING:
    import pandas as pd
    import plotly.graph_objects as go
    from pymoo.core.problem import Problem

    from mgeo.plugins.shown import Review

#: By how much equality constraints may be off, as in pymoo.
TOLERANCE = 1e-4


class View:
    """Solutions of a problem as people are shown them.

    A problem that has more to say than its numbers gives a subclass of it by a method ``view(X)``.
    A view is made once for its solutions, so that what it evaluates for one of its answers can be
    a cached property, and serve all. Whatever concerns the problem alone, `impossible`, `facts`,
    `notes` and `front_summary`, needs no solutions: it is asked of a view of none.

    Parameters
    ----------
    problem : Problem
    X : array_like, shape (n, n_var)
        Solutions as numbers, of a choice that of its option, or dicts of their variables; n may be
        0. One solution may be a row.

    Attributes
    ----------
    X : array, shape (n, n_var)
        As numbers.

    Raises
    ------
    ValueError
        For another shape.

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
        """Objectives, shape (n, n_obj), as a run has found them, or else evaluated."""
        return self._values[0]

    def take(self, rows: ArrayLike) -> View:
        """A view of some of the solutions, by their rows.

        A subclass lets it share what it knows of them already.
        """
        places = np.asarray(rows, dtype=np.int64)
        known = self.F[places] if "F" in self.__dict__ else None
        return view_of(self.problem, self.X[places], known)

    def describe(self) -> pd.DataFrame:
        """A row for each solution, in the words of the domain; here objectives and variables."""
        import pandas as pd

        variables, objectives = column_names(self.problem)
        return pd.DataFrame(np.hstack([self.F, self.X]), columns=[*objectives, *variables])

    def glance(self) -> pd.DataFrame:
        """Of `describe` what is known within milliseconds, while a hand moves a variable.

        Numbers are what counts; here it is `describe` itself.
        """
        return self.describe()

    def answers(self) -> list[str]:
        """For each solution a line that says what it is worth; here its objectives."""
        _, names = column_names(self.problem)
        return [
            ", ".join(f"{name} {value:.5g}" for name, value in zip(names, row, strict=True))
            for row in self.F.tolist()
        ]

    def limits(self) -> list[pd.DataFrame]:
        """For each solution a table, with a row for each limit by its name.

        Columns: ``unit``, ``value``, ``bound`` ("at most" or "at least"), ``limit`` and ``margin``,
        below zero where it is exceeded. Here of the constraints, of which only the margin is known:
        ``value`` and ``limit`` are NaN.
        """
        import pandas as pd

        index = pd.Index(constraint_names(self.problem), name="constraint", dtype=str)
        other = {"unit": "", "value": np.nan, "bound": "at most", "limit": np.nan}
        return [pd.DataFrame({**other, "margin": row}, index=index) for row in self.margins]

    @cached_property
    def margins(self) -> FloatArray:
        """What constraints, inequalities first, leave of their limits, shape (n, g + h)."""
        _, G, H = self._values
        return -excess(G, H)

    def arrays(self) -> dict[str, np.ndarray[Any, Any]]:
        """Return further arrays to store with a front, shape (n, ...) each, by name; here none.

        They are written into ``front.npz`` beside X, F, G and H, and read as
        ``read_run(folder).outcome.arrays``.
        """
        return {}

    def remarks(self) -> list[str]:
        """Lines about the solutions as a whole, a front; here none."""
        return []

    def ways_out(self) -> list[str]:
        """Lines about solutions that come nearest where none keeps all limits; here none."""
        return []

    def figures(self) -> dict[str, go.Figure]:
        """Figures of the solutions together, ``front`` among them.

        A report lets one choose points of it whose ``customdata`` is the number of their row. Here
        it is `plain_front`.
        """
        figure = self.plain_front(type(self.problem).__name__)
        return {} if figure is None else {"front": figure}

    def plain_front(self, title: str = "") -> go.Figure | None:
        """A front of up to three objectives as it is drawn for any problem, None of more."""
        from mgeo.figures.front import MOST_OBJECTIVES, MOST_TEXTS, front_figure

        if self.problem.n_obj > MOST_OBJECTIVES:
            return None
        told = is_own(self, View.describe) and len(self.X) <= MOST_TEXTS
        described = ask(self, View.describe) if told else None
        return front_figure(self.X, self.F, *column_names(self.problem), title, described)

    def solution_figures(self) -> list[dict[str, go.Figure]]:
        """For each solution small figures of it alone, which may move; here none."""
        return [{} for _ in self.X]

    def drawings(self) -> list[dict[str, dict[str, Any]]]:
        """`solution_figures` as trees of plotly, dicts of ``data`` and ``layout`` with arrays.

        A problem that makes these has figures of a whole front in a tenth of the time.
        """
        return [
            {name: figure.to_plotly_json() for name, figure in figures.items()}
            for figures in self.solution_figures()
        ]

    def review(self) -> Review:
        """What a document for a review says of the only solution of this view.

        Here its description and its limits.
        """
        from mgeo.plugins.shown import Review, Section

        described, (limits,) = ask(self, View.describe), ask(self, View.limits)
        facts = ask(self, View.facts)
        shown = described.T.rename(columns={described.index[0]: "value"})
        sections = [Section("What it is about", tuple(f"{k}: {v}" for k, v in facts.items()))]
        sections = sections if facts else []
        sections.append(Section("Solution", table=shown))
        if len(limits):
            sections.append(Section("Limits", table=limits))
        title, (answer,) = type(self.problem).__name__, ask(self, View.answers)
        return Review(title, answer, tuple(sections))

    def impossible(self) -> list[str]:
        """Lines that say why nothing at all can keep the limits, and what to relax; here none."""
        return []

    def facts(self) -> dict[str, str]:
        """What the problem is about, by what is told, for ``--dry-run`` and reports; here none."""
        return {}

    def notes(self) -> list[str]:
        """Lines about the problem as it stands, for ``--dry-run``; here none."""
        return []

    def front_summary(self, F: FloatArray) -> dict[str, float]:
        """Numbers about a front, shape (n, n_obj): columns of a study's table; here none."""
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
    """The view of solutions, shape (n, n_var): the problem's own, or else a `View`.

    Parameters
    ----------
    X
        Default: none, for what concerns the problem alone.
    F
        Their objectives, shape (n, n_obj), if they are known.

    Raises
    ------
    PluginError
        (a ValueError) If the problem's ``view(X)`` raises, or gives something else.

    Examples
    --------
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import view_of
    >>> type(view_of(ZDT1(n_var=2), [[0.25, 0.0]])).__name__
    'View'
    """
    given = np.empty((0, problem.n_var)) if X is None else _numbers(problem, X)
    own = asked(problem, "view(X)", lambda made: isinstance(made, View), "a View", given)
    view = View(problem, given) if own is None else own
    if old := _old_attributes(problem):
        _deprecate(cast(Hashable, type(problem)), old)
        methods = {name: _delegated(name) for name in old}
        view.__class__ = type(type(view).__name__, (type(view),), methods)
    if F is not None:
        view.F = F
    return view


def front_of(view: View, title: str) -> go.Figure | None:
    """The problem's own ``front``, or else the plain one; None of no solutions, or if none can."""
    if not len(view.X):
        return None
    own = ask(view, View.figures).get("front") if is_own(view, View.figures) else None
    return view.plain_front(title) if own is None else own


def excess(G: FloatArray, H: FloatArray) -> FloatArray:
    """By how much constraints are exceeded, at most zero where they are kept, shape (n, g + h)."""
    return np.hstack([np.asarray(G, dtype=float), np.abs(np.asarray(H, dtype=float)) - TOLERANCE])


def is_own(view: View, method: Callable[..., object]) -> bool:
    """Whether a view has its own of a method, such as ``View.describe``."""
    return getattr(type(view), method.__name__) is not method


#: What a problem could have before there was a `View`, and whether it took solutions.
_OLD: Mapping[str, bool] = {
    **dict.fromkeys(("describe", "answers", "limits", "remarks", "ways_out"), True),
    **dict.fromkeys(("figures", "solution_figures"), True),
    **dict.fromkeys(("impossible", "notes", "front_summary"), False),
}


def _old_attributes(problem: Problem) -> tuple[str, ...]:
    """Those that a problem has of its own, or by a class below the one that has ``view``."""
    kinds = type(problem).__mro__
    below = next((i for i, kind in enumerate(kinds) if "view" in vars(kind)), len(kinds))
    places = [vars(problem), *map(vars, kinds[:below])]
    return tuple(name for name in _OLD if any(place.get(name) is not None for place in places))


@functools.cache
def _deprecate(kind: Any, old: tuple[str, ...]) -> None:
    warnings.warn(
        f"{kind.__name__} has {', '.join(old)} of its own: make them methods, without X, of a "
        "subclass of mgeo.View that its view(X) gives; gone in 0.4",
        DeprecationWarning,
        stacklevel=3,
    )


def _delegated(name: str) -> Callable[..., Any]:
    def method(self: View, *given: Any) -> Any:
        return getattr(self.problem, name)(*([self.X] if _OLD[name] else []), *given)

    method.__name__ = name
    return method


def _numbers(problem: Problem, X: ArrayLike) -> FloatArray:
    given = np.asarray(X)
    if given.dtype == object:
        given = as_numbers(problem, np.atleast_1d(given))
    numbers: FloatArray = np.atleast_2d(np.array(given, dtype=float))
    if numbers.ndim != 2 or numbers.shape[1] != problem.n_var:
        raise ValueError(f"X of shape {np.shape(X)}: expected (n, {problem.n_var})")
    return numbers
