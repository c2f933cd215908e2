"""``mgeo resume``: go on with the run of a folder."""

from __future__ import annotations

import warnings
from pathlib import Path

from mgeo.cli.errors import bad_input
from mgeo.cli.output import Output
from mgeo.cli.running import run_to_folder
from mgeo.runs.persistence import RunPersistence
from mgeo.runs.resume import resume_run


def run(
    folder: Path, evaluations: int | None, generations: int | None, check: bool, output: Output
) -> int:
    """Do it; the exit code, as of ``mgeo solve``."""
    with bad_input():
        if evaluations is not None and generations is not None:
            raise ValueError("--evaluations and --generations are both given: expected one")
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", RuntimeWarning)
            resumed = resume_run(
                folder, evaluations=evaluations, generations=generations, check=check
            )
        for warning in told:
            output.note(f"Note: {warning.message}")
        record = resumed.notes is not None and resumed.notes.record
        persistence = RunPersistence(
            folder, resumed.configuration, resumed.algorithm, record=record
        )
    return run_to_folder(resumed, persistence, output, overwrite=True)
