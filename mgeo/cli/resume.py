"""``mgeo resume``: go on with the run of a folder."""

from __future__ import annotations

import warnings
from pathlib import Path

import typer

from mgeo.cli.errors import one_line_errors
from mgeo.cli.running import run_to_folder
from mgeo.runs import Keeper, resume_run


def run(
    folder: Path,
    *,
    evaluations: int | None,
    generations: int | None,
    quiet: bool,
    debug: bool,
) -> int:
    """Do it; the exit code, as of ``mgeo solve``."""
    with one_line_errors(debug):
        if evaluations is not None and generations is not None:
            raise ValueError("--evaluations and --generations are both given: expected one")
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", RuntimeWarning)
            resumed = resume_run(folder, evaluations=evaluations, generations=generations)
        for warning in told:
            typer.echo(f"Note: {warning.message}", err=True)
        record = resumed.notes["record"]
        keeper = Keeper(folder, resumed.recipe, resumed.algorithm, record=record)
    return run_to_folder(resumed, keeper, quiet=quiet, debug=debug)
