"""Views, which present solutions of a problem as tables, figures and texts.

Reports, the explorer and the command line call the methods of a view.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

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

    from mgeo.plugins.review import Review, Section

#: Maximum number of rows of a table on the screen of a solution.
MAX_ROWS = 8
#: Largest absolute value of a satisfied equality constraint, as in pymoo.
EQUALITY_TOLERANCE = 1e-4


class View:
    """Presentation of the solutions to a problem as tables, figures and text.

    Each method has a default that works for any pymoo problem. A problem customizes its
    presentation by returning a subclass from its method ``view(X)``. mgeo calls several methods of
    the same view; share expensive results between methods by a cached property. The methods
    `infeasibility_reasons`, `facts`, `notes` and `front_summary` describe the problem and are also
    called on a view without solutions.

    Parameters
    ----------
    problem : Problem
    X : array_like, shape (n, n_var)
        Designs of the solutions as numbers, with a choice as the index of its option, or as dicts
        by variable name; n may be 0. An array of shape (n_var,) is one solution.

    Attributes
    ----------
    X : array, shape (n, n_var)
        Designs of the solutions as numbers.
    noun : str
        Word for a solution in the field of the problem, such as "plan".

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

    noun: ClassVar[str] = "solution"

    def __init__(self, problem: Problem, X: ArrayLike) -> None:
        self.problem = problem
        self.X = _convert_to_numbers(problem, X)

    @cached_property
    def F(self) -> FloatArray:
        """Objectives of the solutions, evaluated on first access unless they were given.

        An array of shape (n, n_obj).
        """
        return self._values[0]

    def select(self, rows: ArrayLike) -> View:
        """Return a view of the solutions with the given row indices.

        A subclass may override this method to pass on results that it has already computed.
        """
        indices = np.asarray(rows, dtype=np.int64)
        evaluated_F = self.F[indices] if "F" in self.__dict__ else None
        return build_view(self.problem, self.X[indices], evaluated_F)

    def describe(self) -> pd.DataFrame:
        """Return a table with one row per solution. The default lists objectives and variables."""
        import pandas as pd

        variables, objectives = get_column_names(self.problem)
        return pd.DataFrame(np.hstack([self.F, self.X]), columns=[*objectives, *variables])

    def quick_metrics(self) -> pd.DataFrame:
        """Return a table of quickly computed metrics, with one row per solution.

        The explorer shows them while a user moves its sliders. The default is `describe`.
        """
        return self.describe()

    def summaries(self) -> list[str]:
        """Return a one-line summary of each solution. The default lists the objectives."""
        _, names = get_column_names(self.problem)
        return [
            ", ".join(f"{name} {value:.5g}" for name, value in zip(names, row, strict=True))
            for row in self.F.tolist()
        ]

    def overview(self) -> dict[str, Section]:
        """Return sections that describe a single solution on less than one screen.

        ``mgeo solve`` prints the sections for the recommended solution. The view must have exactly
        one solution.

        Returns
        -------
        dict of str to Section
            Sections by their keys in JSON documents. The default consists of `summaries`, if the
            problem defines them, `describe` and `constraints`.
        """
        from mgeo.plugins.review import Section

        (constraints,) = self.constraints()
        lines = tuple(self.summaries()) if has_override(self, View.summaries) else ()
        table = self.describe().T.set_axis(["value"], axis="columns").rename_axis("quantity")
        sections = {
            "summary": Section("", lines),
            "values": Section(
                self.noun.capitalize(), table=table, max_rows=MAX_ROWS, full_command="mgeo report"
            ),
        }
        if len(constraints):
            sections["constraints"] = build_constraint_section(constraints)
        return sections

    def front_table(self) -> pd.DataFrame:
        """Return a compact table for comparing solutions, with one row per solution.

        ``mgeo solve`` prints the rows of about five solutions of the front. The default is a table
        of the objectives.
        """
        import pandas as pd

        return pd.DataFrame(self.F, columns=list(get_column_names(self.problem)[1]))

    def constraints(self) -> list[pd.DataFrame]:
        """Return one table per solution with the value, bound and margin of each constraint.

        Returns
        -------
        list of DataFrame
            One table per solution, with constraint names as index. Columns are ``unit``, ``value``,
            ``bound_type`` ("at most" or "at least"), ``bound_value`` and ``margin``. A negative
            margin is a violation. By default, ``value`` and ``bound_value`` are NaN, because a
            pymoo problem provides only margins.
        """
        import pandas as pd

        index = pd.Index(get_constraint_names(self.problem), name="constraint", dtype=str)
        columns = {"unit": "", "value": np.nan, "bound_type": "at most", "bound_value": np.nan}
        return [pd.DataFrame({**columns, "margin": row}, index=index) for row in self.margins]

    @cached_property
    def margins(self) -> FloatArray:
        """Constraint margins of each solution, negative where a constraint is violated.

        The shape is (n, n_ieq_constr + n_eq_constr), with inequalities first.
        """
        _, G, H = self._values
        return -compute_violations(G, H)

    def arrays(self) -> dict[str, np.ndarray[Any, Any]]:
        """Return a dict that maps names to additional arrays to store with the front.

        There are none by default. Each array has the shape (n, ...). A run stores the arrays in
        ``front.npz`` next to X, F, G and H; ``read_run(folder)`` returns them as
        ``outcome.arrays``.
        """
        return {}

    def format_title(self, name: str) -> str:
        """Return the display title of an objective or of a column of `describe`.

        Reports and the explorer show the title. The default is the name itself.
        """
        return name

    def warnings(self) -> list[str]:
        """Return warnings about the solutions and the problem. The default is `notes`.

        A warning is one sentence on the fact, and one on what to do.
        """
        return self.notes()

    def next_commands(self, folder: str) -> dict[str, str]:
        """Return a dict of commands that a user can run next on the solutions.

        Parameters
        ----------
        folder : str
            Run folder.

        Returns
        -------
        dict of str to str
            Commands by purpose, such as ``{"Print the plan": "mgeo attitude show runs/a"}``.
        """
        return {}

    def suggestions(self) -> list[str]:
        """Return one-line suggestions for making an infeasible problem feasible.

        The list is empty by default.
        """
        return []

    def figures(self) -> dict[str, go.Figure]:
        """Return a dict of figures that show all solutions. The default is a front plot.

        Points of the figure ``front`` are clickable in reports if their ``customdata`` is the row
        index of the solution.
        """
        figure = self.default_front_figure(type(self.problem).__name__)
        return {} if figure is None else {"front": figure}

    def default_front_figure(self, title: str = "") -> go.Figure | None:
        """Return a scatter plot of the objectives, or None if there are more than three."""
        from mgeo.figures.front import MAX_HOVER_TEXTS, MAX_OBJECTIVES, draw_front

        if self.problem.n_obj > MAX_OBJECTIVES:
            return None
        has_texts = has_override(self, View.describe) and len(self.X) <= MAX_HOVER_TEXTS
        described = call_optional(self, View.describe) if has_texts else None
        return draw_front(self.X, self.F, *get_column_names(self.problem), title, described)

    def solution_figures(self) -> list[dict[str, go.Figure]]:
        """Return one dict of small figures per solution, keyed by figure name.

        Figures may be animated. There are none by default.
        """
        return [{} for _ in self.X]

    def figure_dicts(self) -> list[dict[str, dict[str, Any]]]:
        """Return the `solution_figures` in plotly's JSON format instead of plotly objects.

        A dict has the keys ``data`` and ``layout`` of plotly's JSON format and may contain arrays.
        A subclass that builds the dicts directly avoids the validation by plotly, which takes 90 %
        of the time.
        """
        return [
            {name: figure.to_plotly_json() for name, figure in figures.items()}
            for figures in self.solution_figures()
        ]

    def review(self) -> Review:
        """Return a review document of a single solution. The default lists values and constraints.

        The view must have exactly one solution.
        """
        from mgeo.plugins.review import Review, Section

        facts = tuple(f"{name}: {text}" for name, text in self.facts().items())
        problem = (Section("Problem", facts),) if facts else ()
        title, (summary,) = type(self.problem).__name__, self.summaries()
        sections = tuple(each for each in View.overview(self).values() if each.title)
        return Review(title, summary, (*problem, *sections))

    def infeasibility_reasons(self) -> list[str]:
        """Return one-line reasons why no design of the problem can be feasible.

        An empty list, the default, if no such reason is known.
        """
        return []

    def facts(self) -> dict[str, str]:
        """Return short facts about the problem as a dict keyed by label. The default is empty.

        ``--dry-run`` and reports show them.
        """
        return {}

    def notes(self) -> list[str]:
        """Return one-line notes about the problem. The default is an empty list.

        The list is empty by default.
        """
        return []

    def front_summary(self, F: FloatArray) -> dict[str, float]:
        """Return a dict of metrics of a front for the tables of studies. The default is empty.

        Parameters
        ----------
        F : array, shape (n, n_obj)
            Objectives of the points of the front.
        """
        return {}

    @cached_property
    def _values(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        # Returns F, G and H. The import is deferred, because it loads all algorithms.
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
    """Return the view of a problem for the given solutions.

    Parameters
    ----------
    problem : Problem
    X : array_like, shape (n, n_var), optional
        Designs of the solutions. Without them, the view only describes the problem.
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
    """Return the figure ``front`` of a view, or a scatter plot of the objectives by default.

    None if the view has no solutions.
    """
    if not len(view.X):
        return None
    figures = call_optional(view, View.figures) if has_override(view, View.figures) else {}
    figure = figures.get("front")
    return view.default_front_figure(title) if figure is None else figure


def compute_violations(G: FloatArray, H: FloatArray) -> FloatArray:
    """Return the violation of each constraint, positive where it is violated.

    Parameters
    ----------
    G : array, shape (n, n_ieq_constr)
        Inequality constraints, satisfied where G <= 0.
    H : array, shape (n, n_eq_constr)
        Equality constraints, satisfied where abs(H) <= `EQUALITY_TOLERANCE`.

    Returns
    -------
    array, shape (n, n_ieq_constr + n_eq_constr)
        G and abs(H) - `EQUALITY_TOLERANCE`, side by side.
    """
    return np.hstack(
        [np.asarray(G, dtype=float), np.abs(np.asarray(H, dtype=float)) - EQUALITY_TOLERANCE]
    )


def build_constraint_section(constraints: pd.DataFrame) -> Section:
    """Return a section with the constraints of one solution, smallest margins first.

    Parameters
    ----------
    constraints : DataFrame
        Table of one solution, as in `View.constraints`.
    """
    import pandas as pd

    from mgeo.plugins.review import Section

    scale = constraints["bound_value"].abs().replace(0.0, np.nan).fillna(1.0)
    order = np.argsort((constraints["margin"] / scale).to_numpy(float), kind="stable")
    table = constraints.iloc[order]
    columns: dict[str, Any] = {"unit": table["unit"]} if table["unit"].ne("").any() else {}
    if table["value"].notna().any():
        bounds = zip(table["bound_type"], table["bound_value"], strict=True)
        columns["value"] = table["value"]
        columns["bound"] = [f"{bound_type} {value:.4g}" for bound_type, value in bounds]
    n_violated = int((table["margin"] < 0.0).sum())
    state = f"{n_violated} of {len(table)} violated" if n_violated else "satisfied"
    frame = pd.DataFrame(columns | {"margin": table["margin"]}, index=table.index)
    title = f"Constraints ({state})"
    return Section(title, table=frame, max_rows=MAX_ROWS, full_command="mgeo report")


def _convert_to_numbers(problem: Problem, X: ArrayLike) -> FloatArray:
    designs = np.asarray(X)
    if designs.dtype == object:
        designs = convert_designs_to_numbers(problem, np.atleast_1d(designs))
    numbers: FloatArray = np.atleast_2d(np.array(designs, dtype=float))
    if numbers.ndim != 2 or numbers.shape[1] != problem.n_var:
        raise ValueError(f"X of shape {np.shape(X)}: expected (n, {problem.n_var})")
    return numbers
