"""Commands and options of ``mgeo suite``.

Each command imports its modules when it is run, so that the command line starts quickly.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from mgeo.cli.app import format_examples
from mgeo.cli.errors import convert_input_errors
from mgeo.cli.options import Debug, Json
from mgeo.terminal import Output, build_table

app = typer.Typer(help="Sensor suites: list a catalog, and summarize a front of suites.")

EXAMPLES: Mapping[str, tuple[str, ...]] = {
    "catalog": ("mgeo suite catalog", "mgeo suite catalog mine.toml --json"),
    "conclude": (
        "mgeo suite conclude runs/suite-mgeo-directed-seed1",
        "mgeo suite conclude runs/suite-mgeo-directed-seed1 --budget 5 --budget 50",
    ),
}

_DEFAULT_BUDGETS_KEUR = (10.0, 30.0, 60.0)  # default budgets [kEUR]


@app.command(epilog=format_examples("catalog", EXAMPLES))
def catalog(
    file: Annotated[
        Path | None,
        typer.Argument(metavar="FILE.toml", help="Catalog [default: built-in catalog]."),
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Print the price, mass, power and source of each grade of a catalog."""
    from mgeo_suite.catalog import SECTIONS, Catalog

    with convert_input_errors():
        found = Catalog.default() if file is None else Catalog.from_toml(file)
    output = Output(json=json)
    output.print_document(found.to_dict())
    titles = ("", "price [kEUR]", "mass [g]", "power [mW]", "source")
    rows: list[tuple[Any, ...]] = []
    for section in SECTIONS:
        for grade in getattr(found, section):
            one = grade.cost
            name = f"{section.removesuffix('s').replace('_', ' ')} {one.name}"
            rows.append((name, one.price_keur, one.mass_g, one.power_mw, one.source))
    output.print(build_table(titles, rows))


@app.command(epilog=format_examples("conclude", EXAMPLES))
def conclude(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Run folder of `mgeo solve suite`.")],
    budget: Annotated[
        list[float] | None,
        typer.Option(min=0.0, metavar="KEUR", help="Budgets [default: 10, 30 and 60]."),
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Summarize a front of price against accuracy at several budgets, in sentences."""
    import numpy as np

    from mgeo.plugins.problems import load_problem
    from mgeo.store.run_folder import read_run
    from mgeo_suite.problem import SensorSuiteProblem
    from mgeo_suite.view import summarize_front

    with convert_input_errors():
        found = read_run(run)
        problem = load_problem(found.configuration.problem, found.configuration.options)
        if not isinstance(problem, SensorSuiteProblem):
            raise ValueError(f"{run} is a run of {found.configuration.problem!r}: expected 'suite'")
        if not {"price", "attitude"} <= set(problem.objectives):
            minimized = ", ".join(problem.objectives)
            raise ValueError(f"{run} minimizes {minimized}: expected price and attitude among them")
        if not len(found.outcome.F):
            raise ValueError(f"{run} has no front to conclude from")
    budgets = np.array(budget if budget else _DEFAULT_BUDGETS_KEUR)
    lines = summarize_front(problem, found.outcome.X, found.outcome.F, budgets)
    output = Output(json=json)
    output.print_document({"summary": lines})
    output.print(*lines)
