"""Commands ``mgeo suite``.

Each command imports slow modules when it is run, so that the command line starts quickly.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mgeo.cli.errors import convert_input_errors
from mgeo.cli.help_text import format_examples
from mgeo.cli.options import Debug, Json
from mgeo.plugins.review import Section
from mgeo.terminal import Output

if TYPE_CHECKING:
    from mgeo_suite.documents import ConcludeDocument

    pass

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
    """Print the price, mass, power and source of each sensor grade in a catalog."""
    import pandas as pd

    from mgeo_suite.catalog import SECTIONS, Catalog

    with convert_input_errors():
        selected = Catalog.default() if file is None else Catalog.from_toml(file)
    output = Output(json=json)
    output.print_document(selected.to_dict())
    grades = [
        (f"{section.removesuffix('s').replace('_', ' ')} {grade.cost.name}", grade.cost)
        for section in SECTIONS
        for grade in getattr(selected, section)
    ]
    rows = [
        (name, *(f"{value:g}" for value in (cost.price_keur, cost.mass_g, cost.power_mw)))
        for name, cost in grades
    ]
    table = pd.DataFrame(rows, columns=["sensor", "price [kEUR]", "mass [g]", "power [mW]"])
    output.print_sections(
        Section("", table=table),
        Section("Sources", tuple(f"- {name}: {cost.source}" for name, cost in grades)),
    )


@app.command(epilog=format_examples("conclude", EXAMPLES))
def conclude(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Run folder of `mgeo solve suite`.")],
    budget: Annotated[
        list[float] | None,
        typer.Option(
            min=0.0,
            metavar="KEUR",
            help="Budget in thousands of euros. Can be repeated [default: 10, 30 and 60].",
        ),
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Print the most accurate suite within each budget and the lowest price for each accuracy."""
    import pandas as pd

    from mgeo.plugins.problems import load_problem
    from mgeo.store.run_folder import read_run
    from mgeo_suite.front_summary import find_best_suites, find_lowest_prices
    from mgeo_suite.problem import SensorSuiteProblem

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
    X, F = loaded.outcome.X, loaded.outcome.F
    suites = find_best_suites(problem, X, F, budget or _DEFAULT_BUDGETS_KEUR)
    prices = find_lowest_prices(problem, X, F)
    output = Output(json=json)
    document: ConcludeDocument = {"folder": str(run), "budgets": suites, "accuracies": prices}
    output.print_document(document)
    within_budgets = pd.DataFrame(
        {
            "budget [kEUR]": [_format(each["budget_keur"]) for each in suites],
            "price [kEUR]": [_format(each["price_keur"]) for each in suites],
            "attitude 1-sigma [deg]": [_format(each["attitude_1sigma_deg"], 2) for each in suites],
            "solution": [_format(each["solution"]) for each in suites],
        }
    )
    titles = ["attitude 1-sigma [deg]", "price [kEUR]", "without star tracker [kEUR]"]
    lowest = [
        (
            _format(each["attitude_1sigma_deg"]),
            _format(each["price_keur"]),
            _format(each["price_without_star_tracker_keur"]),
        )
        for each in prices
    ]
    texts = (f"- {each['budget_keur']:g} kEUR: {each['suite'] or 'no suite'}" for each in suites)
    output.print_sections(
        Section("Most accurate suite within each budget", (), within_budgets, "\n".join(texts)),
        Section("Lowest price of each accuracy", table=pd.DataFrame(lowest, columns=titles)),
    )
    output.print_commands({"Show a suite": f"mgeo report {run} --solution N"})


def _format(value: float | None, digits: int = 3) -> str:
    return "-" if value is None else f"{value:.{digits}g}"
