"""Summary of a front: representative solutions, constraint margins, and suggestions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mgeo.plugins.protocol import call_optional, get_indicator_map, get_objective_labels
from mgeo.plugins.view import View
from mgeo.runs.hypervolume import scale_objectives

if TYPE_CHECKING:
    import pandas as pd
    from pymoo.core.problem import Problem

    from mgeo.plugins.review import Section

# In fronts scaled to size 1, distances below this value are rounding errors.
_FLATNESS_TOLERANCE = 1e-9
_MARGIN_COLUMNS = ["margin", "unit", "value", "bound_type", "bound_value"]
_MAX_RELAXATIONS = 3  # Maximum number of suggested combinations of constraints to relax.


@dataclass(frozen=True)
class RepresentativeSolution:
    """Solution that is selected to represent a front, with the reason for its selection.

    Attributes
    ----------
    row : int
        Row of the solution.
    label : str
        Reason, such as "knee", "min-mass" or "intermediate".
    """

    row: int
    label: str


@dataclass(frozen=True)
class FrontSummary:
    """Summary of a front: recommended solution, representative solutions, and warnings.

    Attributes
    ----------
    recommended : RepresentativeSolution
        Knee of the front or, without a knee, the solution with the smallest first objective.
    text : str
        Summary of the recommended solution in one line.
    overview : dict of str to Section
        Overview of the recommended solution.
    constraints : DataFrame
        Constraints of the recommended solution, as in `View.constraints`.
    front : DataFrame
        Rows of `View.front_table`, with the row in the front as index and two more columns in
        front: ``label``, and ``violated``, a list of the names of violated constraints.
    warnings : list of str
        Warnings of the problem.
    """

    recommended: RepresentativeSolution
    text: str
    overview: dict[str, Section]
    constraints: pd.DataFrame
    front: pd.DataFrame
    warnings: list[str]


def summarize_front(view: View) -> FrontSummary:
    """Summarize the front shown by a view, which must contain at least one solution."""
    recommended = select_default_solution(view.problem, view.F)
    solution = view.select([recommended.row])
    (text,) = call_optional(solution, View.summaries)
    representatives = select_representative_solutions(view.problem, view.F)
    rows = [each.row for each in representatives]
    selection = view.select(rows)
    front = call_optional(selection, View.front_table).set_axis(rows, axis="index")
    # Solutions of a front satisfy the constraints of the optimization, but a problem may report
    # further constraints.
    tables = dict(zip(rows, call_optional(selection, View.constraints), strict=True))
    front.insert(0, "label", [each.label for each in representatives])
    front.insert(1, "violated", [_list_violated(table) for table in tables.values()])
    constraints = tables[recommended.row]
    overview = call_optional(solution, View.overview)
    # Warnings can take seconds to compute.
    warnings = list(call_optional(view, View.warnings))
    if violated := _list_violated(constraints):
        satisfying = [row for row, table in tables.items() if not _list_violated(table)]
        advice = f"Choose another {view.noun}"
        if satisfying:
            place = rows.index(recommended.row)
            nearest = min(satisfying, key=lambda row: abs(rows.index(row) - place))
            advice = f"Choose {view.noun} {nearest}, which satisfies all constraints"
        warnings.insert(
            0,
            f"The recommended {view.noun} violates a constraint: {', '.join(violated)}. "
            f"{advice}, or change the constraint.",
        )
    return FrontSummary(recommended, text, overview, constraints, front, warnings)


def _list_violated(constraints: pd.DataFrame) -> list[str]:
    return [str(name) for name in constraints.index[constraints["margin"] < 0.0]]


def select_representative_solutions(problem: Problem, F: ArrayLike) -> list[RepresentativeSolution]:
    """Return about five solutions of a front: extremes, knee, and points between them.

    The solutions are sorted by the first objective. There are more than five if the front has more
    than four objectives, and fewer if the front is smaller. Distances are computed in the problem's
    indicator space, or with the front scaled to its own extent if the problem has none.

    Parameters
    ----------
    problem : Problem
        Problem of the front.
    F : array_like, shape (n, n_obj)
        Objectives of the front.

    Returns
    -------
    list of RepresentativeSolution
        Labels are "min-" and the name of the objective, "knee", and "intermediate".
    """
    front = np.asarray(F, dtype=float)
    if not len(front):
        return []
    points = _scale_front(problem, front)
    labels: dict[int, list[str]] = {}
    for row, name in zip(find_extremes(points), get_objective_labels(problem), strict=True):
        labels.setdefault(row, []).append(f"min-{name}")
    knee_row = find_knee(points)
    if knee_row is not None:
        labels[knee_row] = ["knee"]
    for row in _select_spread_rows(points, list(labels), max(5, len(labels))):
        labels[row] = ["intermediate"]
    rows = sorted(labels, key=lambda row: tuple(front[row]))
    return [RepresentativeSolution(row, ", ".join(labels[row])) for row in rows]


def select_default_solution(problem: Problem, F: ArrayLike) -> RepresentativeSolution:
    """Return the knee of a front or, without a knee, the solution with the smallest first
    objective.

    Parameters
    ----------
    problem : Problem
        Problem of the front.
    F : array_like, shape (n, n_obj)
        Objectives of the front, n >= 1.

    Returns
    -------
    RepresentativeSolution
    """
    points = _scale_front(problem, np.asarray(F, dtype=float))
    row = find_knee(points)
    if row is not None:
        return RepresentativeSolution(row, "knee")
    label = get_objective_labels(problem)[0]
    return RepresentativeSolution(find_extremes(points)[0], f"min-{label}")


def find_extremes(points: NDArray[np.float64]) -> list[int]:
    """Return the index of the best point in each objective.

    Ties are broken by the sum of all objectives.
    """
    total = points.sum(axis=1)
    return [int(np.lexsort((total, column))[0]) for column in points.T]


def find_knee(points: NDArray[np.float64]) -> int | None:
    """Return the index of the knee: the point farthest from the plane through the extremes.

    Only points on the side of the ideal point are considered.

    Returns
    -------
    int or None
        None if no point is on this side, as in a straight or concave front.
    """
    corners = points[find_extremes(points)]
    normal = _compute_normal(corners)
    bulge = (corners[0] - points) @ normal
    row = int(np.argmax(bulge))
    return row if bulge[row] > _FLATNESS_TOLERANCE else None


def _scale_front(problem: Problem, front: NDArray[np.float64]) -> NDArray[np.float64]:
    """Map a front to the problem's indicator space or, if there is none, to [0, 1]."""
    space = get_indicator_map(problem)
    return space(front) if space else scale_objectives(front, front.min(axis=0), front.max(axis=0))


def _compute_normal(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the unit normal of the extremes' plane, pointing away from the ideal point."""
    diagonal = np.full(corners.shape[1], corners.shape[1] ** -0.5)
    _, sizes, rows = np.linalg.svd(corners[1:] - corners[0])
    if len(sizes) and sizes[-1] < _FLATNESS_TOLERANCE:
        return diagonal  # Extremes coincide, so the plane is not unique.
    normal: NDArray[np.float64] = rows[-1]
    return normal if normal @ diagonal >= 0 else -normal


def _select_spread_rows(points: NDArray[np.float64], chosen: list[int], n_rows: int) -> list[int]:
    """Repeatedly select the point that is farthest from all points selected so far."""
    added: list[int] = []
    while len(chosen) + len(added) < min(n_rows, len(points)):
        selected = points[chosen + added]
        distance = np.linalg.norm(points[:, None] - selected[None], axis=2).min(axis=1)
        distance[chosen + added] = -1.0  # Duplicates of a chosen point have distance 0.
        added.append(int(np.argmax(distance)))
    return added


@dataclass(frozen=True)
class ConstraintMargin:
    """Margin of one constraint in one solution, negative if the constraint is violated.

    Attributes
    ----------
    name : str
        Name of the constraint.
    margin : float
        Distance to the bound, negative if the constraint is violated; NaN if unknown.
    unit : str
        Unit of value, bound and margin.
    value : float
        Value of the constrained quantity; NaN if the problem defines no ``constraints`` in its
        view. The margin is then in the units of the constraint function.
    bound_type : str
        "at most" or "at least".
    bound_value : float
        Bound; NaN like `value`.
    """

    name: str
    margin: float
    unit: str = ""
    value: float = math.nan
    bound_type: str = ""
    bound_value: float = math.nan

    @property
    def is_satisfied(self) -> bool:
        return self.margin >= 0.0

    @property
    def _unit_suffix(self) -> str:
        return f" {self.unit}" if self.unit not in ("", "-") else ""

    def __str__(self) -> str:
        state = "margin" if self.is_satisfied else "exceeded by"
        text = f"{state} {abs(self.margin):.3g}{self._unit_suffix}"
        if math.isnan(self.value):
            return f"{self.name}: {text}"
        required = f"{self.bound_type} {self.bound_value:.4g}{self._unit_suffix}"
        return f"{self.name}: {self.value:.4g}{self._unit_suffix}, {required}: {text}"

    def format_relaxation(self) -> str:
        """Return text that states by how much the bound must be relaxed.

        The value has three significant digits and is rounded up.
        """
        violation = -self.margin
        if math.isfinite(violation):
            unit = 10.0 ** (math.floor(math.log10(violation)) - 2)
            violation = math.ceil(violation / unit) * unit
        return f"{self.name} by {violation:.3g}{self._unit_suffix}"


def list_constraint_margins(view: View) -> list[list[ConstraintMargin]]:
    """Return the constraint margins of each solution in a view.

    Returns
    -------
    list of lists of ConstraintMargin
        One list per solution, in the problem's order of constraints.
    """
    return _parse_margins(call_optional(view, View.constraints))


def _parse_margins(tables: list[pd.DataFrame]) -> list[list[ConstraintMargin]]:
    return [
        [
            ConstraintMargin(str(name), *row)
            for name, *row in table[_MARGIN_COLUMNS].itertuples(name=None)
        ]
        for table in tables
    ]


@dataclass(frozen=True)
class Violation:
    """Constraint that is violated in a run without a feasible solution.

    The values describe the solutions nearest to feasibility.

    Attributes
    ----------
    smallest : ConstraintMargin
        Smallest violation.
    n_violating, n_solutions : int
        Number of solutions that violate the constraint, and number of all solutions.
    """

    smallest: ConstraintMargin
    n_violating: int
    n_solutions: int

    def __str__(self) -> str:
        return f"{self.smallest} ({self.n_violating} of {self.n_solutions} nearest solutions)"


@dataclass(frozen=True)
class InfeasibilityReport:
    """Violated constraints of a run without a feasible solution, with suggestions.

    Attributes
    ----------
    violations : tuple of Violation
        Constraints that the nearest solutions violate.
    suggestions : tuple of str
        Suggestions of the problem, or else a longer search if the search was short; then sets of
        constraints to relax, smallest sets first.
    """

    violations: tuple[Violation, ...]
    suggestions: tuple[str, ...]

    def build_table(self) -> pd.DataFrame:
        """Return a table with the smallest violation of each constraint.

        Columns: ``unit``, ``value``, ``bound`` and ``violation``; and ``violated by``, the number
        of violating solutions. Columns without content are left out.
        """
        import pandas as pd

        margins = [each.smallest for each in self.violations]
        table = pd.DataFrame(
            {
                "unit": [margin.unit for margin in margins],
                "value": [margin.value for margin in margins],
                "bound": [f"{margin.bound_type} {margin.bound_value:.4g}" for margin in margins],
                "violation": [-margin.margin for margin in margins],
                "violated by": [f"{v.n_violating} of {v.n_solutions}" for v in self.violations],
            },
            index=pd.Index([margin.name for margin in margins], name="constraint"),
        )
        has_units, has_values = table["unit"].ne("").any(), table["value"].notna().any()
        empty = [] if has_values else ["value", "bound"]
        return table.drop(columns=empty + ([] if has_units else ["unit"]))


def explain_infeasibility(view: View, n_evaluations: int) -> InfeasibilityReport:
    """Report which constraints the solutions of a view violate, and suggest remedies.

    Parameters
    ----------
    view : View
        View of at least one infeasible solution.
    n_evaluations : int
        Number of evaluations of the search. A search is short if it has fewer than half of the
        evaluations that are the default without recommended settings of the problem.

    Returns
    -------
    InfeasibilityReport
    """
    from mgeo.algorithms.base import DEFAULT_WALKER_GENERATIONS  # The import is slow.

    # If all constraints reported by the problem are satisfied, use the constraint functions.
    pairs = zip(list_constraint_margins(view), _parse_margins(View.constraints(view)), strict=True)
    rows = [
        [margin for margin in reported if not margin.is_satisfied]
        or [margin for margin in computed if not margin.is_satisfied]
        for reported, computed in pairs
    ]
    by_name: dict[str, list[ConstraintMargin]] = {}
    relaxations: dict[frozenset[str], str] = {}  # Keyed by the names of the constraints.
    for row in sorted(rows, key=len):
        for margin in row:
            by_name.setdefault(margin.name, []).append(margin)
        names = frozenset(margin.name for margin in row)
        terms = " and ".join(margin.format_relaxation() for margin in row)
        relaxations.setdefault(names, f"Relax {terms}.")
    violations = (
        Violation(max(margins, key=lambda m: m.margin), len(margins), len(rows))
        for margins in by_name.values()
    )
    suggestions = list(call_optional(view, View.suggestions))
    default = DEFAULT_WALKER_GENERATIONS * view.problem.n_var
    if not suggestions and n_evaluations < default / 2:
        suggestions = [f"Search longer, for example with --evaluations {default}."]
    suggestions += list(relaxations.values())[:_MAX_RELAXATIONS]
    return InfeasibilityReport(tuple(violations), tuple(suggestions))
