"""The most telling solutions as a table."""

from __future__ import annotations

import pandas as pd
from pymoo.core.problem import Problem
from rich.table import Table

from mgeo import contract
from mgeo.consoles import plain
from mgeo.runs import Outcome, front_table, highlights


def solutions_table(problem: Problem, outcome: Outcome) -> Table:
    """One column per solution, one row per quantity: any number of variables fits a terminal.

    The quantities are those of ``problem.describe``, or else objectives and variables.
    """
    chosen = highlights(problem, outcome.F, outcome.objectives)
    rows = [highlight.row for highlight in chosen]
    described = contract.describe(problem, outcome.X[rows])
    if described is None:
        described = front_table(outcome).iloc[rows][[*outcome.objectives, *outcome.variables]]
    table = Table(box=None, pad_edge=False, show_edge=False, padding=(0, 2, 0, 0))
    table.add_column("")
    for highlight in chosen:
        table.add_column(plain(highlight.label), justify="right")
    for name in described.columns:
        table.add_row(plain(str(name)), *(plain(_shown(value)) for value in described[name]))
    return table


def _shown(value: object) -> str:
    return f"{value:.5g}" if pd.api.types.is_float(value) else str(value)
