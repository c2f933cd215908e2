"""Arguments and options that commands about plans have in common."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mgeo.cli import among

Source = Annotated[
    Path, typer.Argument(metavar="RUN|PLAN.json", help="Folder of `mgeo solve`, or a plan's file.")
]
Pick = Annotated[
    str | None,
    typer.Option(
        metavar="knee|fastest|best",
        help="Solution of the run: where its front bends, its least t_end, its least trace "
        "[default: knee].",
        autocompletion=among(("knee", "fastest", "best")),
    ),
]
Time = Annotated[
    float | None,
    typer.Option(metavar="SECONDS", help="Solution of the run whose t_end is nearest to this."),
]
Solution = Annotated[
    int | None,
    typer.Option(metavar="N", help="Solution of the run by its number, as reports show it."),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace existing files.")]

#: Of what a plan is made from everything is the user's: files, scenarios, extras to install.
USERS = (ValueError, TypeError, OSError, ImportError)
