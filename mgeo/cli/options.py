"""Arguments and flags that commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mgeo.cli import completion
from mgeo.cli.errors import remember_debug

# spelled out, because help and completion must not wait for what the table of them imports
FAMILY = ("mgeo-real", "mgeo-real2", "mgeo-canonical", "mgeo-var", "mgeo-directed")
PYMOO = (
    *("nsga2", "nsga3", "u-nsga3", "spea2", "sms-emoa", "age-moea2", "moead", "ctaea", "gde3"),
    *("nsde", "mopso-cd", "cmopso", "rvea", "random"),
)

Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")]
Json = Annotated[
    bool, typer.Option("--json", help="Print the result as one JSON document, for scripts.")
]
Debug = Annotated[
    bool,
    typer.Option("--debug", callback=remember_debug, help="Show the traceback of an error."),
]
DryRun = Annotated[
    bool,
    typer.Option(
        "--dry-run",
        help="Run and write nothing; tell the size, the files, and about how long it would take.",
    ),
]
Problem = Annotated[
    str,
    typer.Argument(
        help="Name of a problem (see `mgeo problems`).", autocompletion=completion.problems
    ),
]
Scenario = Annotated[
    str | None,
    typer.Option(
        metavar="FILE.toml|PRESET",
        help="Options of the problem: a file, or a preset's name.",
        autocompletion=completion.scenarios,
    ),
]
Algorithm = Annotated[
    str,
    typer.Option(
        metavar="NAME",
        help=f"{', '.join(FAMILY)}, or one of pymoo's: {', '.join(PYMOO)}.",
        autocompletion=completion.among((*FAMILY, *PYMOO)),
    ),
]
Sigma = Annotated[
    str | None,
    typer.Option(
        metavar="NUMBER[,NUMBER...]",
        help="mgeo-real, -real2: standard deviation of the perturbation, one or one per variable "
        "[default: 1.0].",
    ),
]
Tau = Annotated[
    str | None,
    typer.Option(
        metavar="NUMBER|a-geo1|a-geo2",
        help="mgeo-...: exponent of the ranking, or a rule by which it adapts [default: 3.0].",
        autocompletion=completion.among(("a-geo1", "a-geo2")),
    ),
]
Walkers = Annotated[int | None, typer.Option(help="mgeo-...: independent walkers [default: 30].")]
Perturbation = Annotated[
    str | None,
    typer.Option(
        metavar="absolute|relative|range",
        help="mgeo-real, -real2: what sigma is a multiple of: 1, the variable, its range "
        "[default: absolute].",
        autocompletion=completion.among(("absolute", "relative", "range")),
    ),
]
Population = Annotated[
    int | None, typer.Option(help="pymoo's algorithms: population size [default: 100].")
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="Any other parameter of the algorithm, such as bits=12 or restart=archive; may be "
        "given several times.",
    ),
]
Budget = Annotated[
    int | None,
    typer.Option(min=1, help="Budget [default: 5000 generations of one candidate per variable]."),
]
Seed = Annotated[int, typer.Option(min=0, help="Seed of all randomness.")]
Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Replace the run in an existing folder.")
]
Record = Annotated[
    bool, typer.Option("--record", help="Keep every evaluation, in the folder's evaluations/.")
]
Unfinished = Annotated[
    Path,
    typer.Argument(metavar="DIR", help="Folder of the run.", autocompletion=completion.kept_runs),
]
Finished = Annotated[
    Path,
    typer.Argument(metavar="DIR", help="Folder of the run.", autocompletion=completion.runs),
]
StudyFile = Annotated[
    Path,
    typer.Argument(metavar="FILE", help="A study as TOML.", autocompletion=completion.toml_files),
]
