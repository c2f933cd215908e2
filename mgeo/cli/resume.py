"""``mgeo resume``: go on with the run of a folder."""

from __future__ import annotations

from pathlib import Path

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
        resumed = resume_run(folder, evaluations=evaluations, generations=generations)
        record = resumed.notes["record"]
        keeper = Keeper(folder, resumed.recipe, resumed.algorithm, record=record)
    return run_to_folder(resumed, keeper, quiet=quiet, debug=debug)
