"""Commands ``mgeo suite``.

Each command imports slow modules when it is run, so that the command line starts quickly.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from mgeo.cli.errors import convert_input_errors
from mgeo.cli.help_text import format_examples
from mgeo.cli.options import Debug, Json
from mgeo.terminal import Output, build_table

app = typer.Typer(help="List the sensors of a catalog, and summarize a front of sensor suites.")

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
        typer.Argument(metavar="FILE.toml", help="Catalog file [default: the built-in catalog]."),
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Print the price, mass, power and source of each sensor grade of a catalog."""
    from mgeo_suite.catalog import SECTIONS, Catalog

    with convert_input_errors():
        selected = Catalog.default() if file is None else Catalog.from_toml(file)
    output = Output(json=json)
    output.print_document(selected.to_dict())
    titles = ("", "price [kEUR]", "mass [g]", "power [mW]", "source")
    rows: list[tuple[Any, ...]] = []
    for section in SECTIONS:
        for grade in getattr(selected, section):
            cost = grade.cost
            name = f"{section.removesuffix('s').replace('_', ' ')} {cost.name}"
            rows.append((name, cost.price_keur, cost.mass_g, cost.power_mw, cost.source))
    output.print(build_table(titles, rows))


@app.command(epilog=format_examples("conclude", EXAMPLES))
def conclude(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Run folder of `mgeo solve suite`.")],
    budget: Annotated[
        list[float] | None,
        typer.Option(
            min=0.0, metavar="KEUR", help="Budget; can be repeated [default: 10, 30 and 60]."
        ),
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Print the most accurate suite within each budget and the lowest price for each accuracy."""
    import numpy as np

    from mgeo.plugins.problems import load_problem
    from mgeo.store.run_folder import read_run
    from mgeo_suite.problem import SensorSuiteProblem
    from mgeo_suite.view import summarize_front

    with convert_input_errors():
        loaded = read_run(run)
        problem = load_problem(loaded.configuration.problem, loaded.configuration.options)
        if not isinstance(problem, SensorSuiteProblem):
            raise ValueError(
                f"{run} is a run of {loaded.configuration.problem!r}: expected 'suite'"
            )
        if not {"price", "attitude"} <= set(problem.objectives):
            names = ", ".join(problem.objectives)
            raise ValueError(
                f"the objectives of {run} are {names}: expected price and attitude among them"
            )
        if not len(loaded.outcome.F):
            raise ValueError(f"{run} has no feasible solution: expected a run with a front")
    budgets = np.array(budget if budget else _DEFAULT_BUDGETS_KEUR)
    lines = summarize_front(problem, loaded.outcome.X, loaded.outcome.F, budgets)
    output = Output(json=json)
    output.print_document({"summary": lines})
    output.print(*lines)
