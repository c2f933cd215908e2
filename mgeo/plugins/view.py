"""Presentation of solutions: a base class with defaults for any pymoo problem.

Reports, the explorer and the command line call the methods of a view.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mgeo._typing import FloatArray
from mgeo.evaluation.individuals import convert_designs_to_numbers
from mgeo.plugins.protocol import (
    ProblemMixin,
    call_optional,
    get_column_names,
    get_constraint_names,
    has_override,
)

if TYPE_CHECKING:
    import pandas as pd
    import plotly.graph_objects as go
    from pymoo.core.problem import Problem

    from mgeo.plugins.review import Review

#: Tolerance of equality constraints, as in pymoo.
EQUALITY_TOLERANCE = 1e-4


class View:
    """Presentation of solutions of a problem; each method has a default for any problem.

    A problem customizes its presentation by returning a subclass from its method ``view(X)``. mgeo
    calls several methods of the same view; share expensive results between methods by a cached
    property. The methods `infeasibility_reasons`, `facts`, `notes` and `front_summary` describe the problem
    and are also called on a view without solutions.

    Parameters
    ----------
    problem : Problem
    X : array_like, shape (n, n_var)
        Solutions as numbers, with a choice as the index of its option, or as dicts by variable
        name; n may be 0. An array of shape (n_var,) is one solution.

    Attributes
    ----------
    X : array, shape (n, n_var)
        Solutions as numbers.

    Raises
    ------
    ValueError
        If `X` does not have n_var columns.

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
        self.X = _convert_to_numbers(problem, X)

    @cached_property
    def F(self) -> FloatArray:
        """Objectives, shape (n, n_obj): the values passed to `build_view`, or else evaluated."""
        return self._values[0]

    def select(self, rows: ArrayLike) -> View:
        """Return a view of the solutions with the given row indices.

        A subclass may override this method to pass on results that it has already computed.
        """
        indices = np.asarray(rows, dtype=np.int64)
        known = self.F[indices] if "F" in self.__dict__ else None
        return build_view(self.problem, self.X[indices], known)

    def describe(self) -> pd.DataFrame:
        """Return a table with one row per solution; by default, objectives and variables."""
        import pandas as pd

        variables, objectives = get_column_names(self.problem)
        return pd.DataFrame(np.hstack([self.F, self.X]), columns=[*objectives, *variables])

    def quick_metrics(self) -> pd.DataFrame:
        """Return quick metrics of each solution, for interactive sliders.

        A table with one row per solution, computed within milliseconds; by default, `describe`.
        """
        return self.describe()

    def summaries(self) -> list[str]:
        """Return a summary of each solution in one line; by default, its objectives."""
        _, names = get_column_names(self.problem)
        return [
            ", ".join(f"{name} {value:.5g}" for name, value in zip(names, row, strict=True))
            for row in self.F.tolist()
        ]

    def constraints(self) -> list[pd.DataFrame]:
        """Return the constraint table of each solution, with constraint names as index.

        Columns are ``unit``, ``value``, ``bound`` ("at most" or "at least"), ``limit`` and
        ``margin``. A negative margin is a violation. By default, ``value`` and ``limit`` are NaN,
        because a pymoo problem provides only margins.
        """
        import pandas as pd

        index = pd.Index(get_constraint_names(self.problem), name="constraint", dtype=str)
        columns = {"unit": "", "value": np.nan, "bound_type": "at most", "bound_value": np.nan}
        return [pd.DataFrame({**columns, "margin": row}, index=index) for row in self.margins]

    @cached_property
    def margins(self) -> FloatArray:
        """Constraint margins, shape (n, n_ieq_constr + n_eq_constr), inequalities first.

        A negative margin is a violation.
        """
        _, G, H = self._values
        return -compute_violations(G, H)

    def arrays(self) -> dict[str, np.ndarray[Any, Any]]:
        """Return additional arrays, shape (n, ...) each, to store with a front; none by default.

        A run stores them in ``front.npz`` next to X, F, G and H; ``read_run(folder)`` returns them
        as ``outcome.arrays``.
        """
        return {}

    def remarks(self) -> list[str]:
        """Return remarks about the set of solutions, one line each; none by default."""
        return []

    def suggestions(self) -> list[str]:
        """Return suggestions for a problem without feasible solutions; none by default."""
        return []

    def figures(self) -> dict[str, go.Figure]:
        """Return figures of the set of solutions by name; by default ``front``, `default_front_figure`.

        Points of the figure ``front`` are clickable in reports if their ``customdata`` is the row
        of the solution.
        """
        figure = self.default_front_figure(type(self.problem).__name__)
        return {} if figure is None else {"front": figure}

    def default_front_figure(self, title: str = "") -> go.Figure | None:
        """Return the figure of a front with up to three objectives, else None."""
        from mgeo.figures.front import MAX_HOVER_TEXTS, MAX_OBJECTIVES, draw_front

        if self.problem.n_obj > MAX_OBJECTIVES:
            return None
        has_texts = has_override(self, View.describe) and len(self.X) <= MAX_HOVER_TEXTS
        described = call_optional(self, View.describe) if has_texts else None
        return draw_front(self.X, self.F, *get_column_names(self.problem), title, described)

    def solution_figures(self) -> list[dict[str, go.Figure]]:
        """Return small, possibly animated figures of each solution by name; none by default."""
        return [{} for _ in self.X]

    def figure_dicts(self) -> list[dict[str, dict[str, Any]]]:
        """Return `solution_figures` as dicts with ``data`` and ``layout``, which contain arrays.

        A subclass that builds the dicts directly avoids the validation by plotly, which takes 90 %
        of the time.
        """
        return [
            {name: figure.to_plotly_json() for name, figure in figures.items()}
            for figures in self.solution_figures()
        ]

    def review(self) -> Review:
        """Return the review of a single solution; by default, its description and constraints.

        The view must have exactly one solution.
        """
        from mgeo.plugins.review import Review, Section

        described, (limits,) = self.describe(), self.constraints()
        facts = tuple(f"{name}: {text}" for name, text in self.facts().items())
        sections = [Section("Problem", facts)] if facts else []
        table = described.T.rename(columns={described.index[0]: "value"})
        sections.append(Section("Solution", table=table))
        if len(limits):
            sections.append(Section("Limits", table=limits))
        title, (answer,) = type(self.problem).__name__, self.summaries()
        return Review(title, answer, tuple(sections))

    def infeasibility_reasons(self) -> list[str]:
        """Return reasons why the problem has no feasible design; none by default."""
        return []

    def facts(self) -> dict[str, str]:
        """Return facts about the problem by name for ``--dry-run`` and reports; none by default."""
        return {}

    def notes(self) -> list[str]:
        """Return notes about the problem for ``--dry-run``, one line each; none by default."""
        return []

    def front_summary(self, F: FloatArray) -> dict[str, float]:
        """Return metrics of a front, shape (n, n_obj), for tables of studies; none by default."""
        return {}

    @cached_property
    def _values(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        # F, G and H. Deferred import: it loads all algorithms.
        from mgeo.algorithms.variables import convert_numbers_to_designs

        problem = self.problem
        counts = problem.n_obj, problem.n_ieq_constr, problem.n_eq_constr
        if not len(self.X):
            F, G, H = (np.empty((0, count)) for count in counts)
            return F, G, H
        values = problem.evaluate(
            convert_numbers_to_designs(problem, self.X.copy()),
            return_values_of=["F", "G", "H"],
            return_as_dictionary=True,
        )
        F, G, H = (np.asarray(values[name], dtype=float) for name in "FGH")
        return F, G, H


def build_view(problem: Problem, X: ArrayLike | None = None, F: FloatArray | None = None) -> View:
    """Return the view of solutions that a problem defines, by default a `View`.

    Parameters
    ----------
    problem : Problem
    X : array_like, shape (n, n_var), optional
        Solutions. The default is a view without solutions, which only describes the problem.
    F : array, shape (n, n_obj), optional
        Objectives of the solutions, to avoid their evaluation.

    Raises
    ------
    PluginError
        If the method ``view(X)`` of the problem raises.
    ValueError
        If `X` does not have n_var columns.

    Examples
    --------
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import build_view
    >>> type(build_view(ZDT1(n_var=2), [[0.25, 0.0]])).__name__
    'View'
    """
    designs = np.empty((0, problem.n_var)) if X is None else _convert_to_numbers(problem, X)
    view = call_optional(problem, ProblemMixin.view, designs)
    if F is not None:
        view.F = F
    return view


def build_front_figure(view: View, title: str) -> go.Figure | None:
    """Return the figure ``front`` of a view or the plain front; None without solutions."""
    if not len(view.X):
        return None
    own = (
        call_optional(view, View.figures).get("front") if has_override(view, View.figures) else None
    )
    return view.default_front_figure(title) if own is None else own


def compute_violations(G: FloatArray, H: FloatArray) -> FloatArray:
    """Return the excess over the bound of each constraint, positive where violated.

    Parameters
    ----------
    G : array, shape (n, n_ieq_constr)
        Inequality constraints, satisfied where G <= 0.
    H : array, shape (n, n_eq_constr)
        Equality constraints, satisfied where abs(H) <= `TOLERANCE`.

    Returns
    -------
    array, shape (n, n_ieq_constr + n_eq_constr)
    """
    return np.hstack(
        [np.asarray(G, dtype=float), np.abs(np.asarray(H, dtype=float)) - EQUALITY_TOLERANCE]
    )


def _convert_to_numbers(problem: Problem, X: ArrayLike) -> FloatArray:
    designs = np.asarray(X)
    if designs.dtype == object:
        designs = convert_designs_to_numbers(problem, np.atleast_1d(designs))
    numbers: FloatArray = np.atleast_2d(np.array(designs, dtype=float))
    if numbers.ndim != 2 or numbers.shape[1] != problem.n_var:
        raise ValueError(f"X of shape {np.shape(X)}: expected (n, {problem.n_var})")
    return numbers
