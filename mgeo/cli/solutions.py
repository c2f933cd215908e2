"""The most telling solutions as a table."""

from __future__ import annotations

from pymoo.core.problem import Problem
from rich.table import Table

from mgeo.cli.tables import table
from mgeo.plugins import protocol
from mgeo.runs.folder import front_table
from mgeo.runs.representative import representative_solutions
from mgeo.runs.solve import Outcome


def solutions_table(problem: Problem, outcome: Outcome) -> Table:
    """One column per solution, one row per quantity: any number of variables fits a terminal.

    The quantities are those of ``problem.describe``, or else objectives and variables.
    """
    chosen = representative_solutions(problem, outcome.F, outcome.objectives)
    rows = [solution.row for solution in chosen]
    described = protocol.describe(problem, outcome.X[rows])
    if described is None:
        described = front_table(outcome).iloc[rows][[*outcome.objectives, *outcome.variables]]
    titles = ["", *(solution.label for solution in chosen)]
    return table(titles, [(str(name), *described[name]) for name in described.columns])
