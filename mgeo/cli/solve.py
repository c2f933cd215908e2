"""``mgeo solve``: a new run in a folder of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mgeo.cli.dry_run import describe_run
from mgeo.cli.errors import ExitCode, bad_input
from mgeo.cli.output import Output
from mgeo.cli.parameters import flag
from mgeo.cli.running import run_to_folder
from mgeo.runs.algorithms import complete_parameters
from mgeo.runs.folder import check_folder
from mgeo.runs.persistence import RunPersistence
from mgeo.runs.prepare import prepare
from mgeo.runs.scenario import read_scenario


@dataclass(frozen=True)
class Request:
    """What was asked for on the command line."""

    problem: str
    scenario: str | None
    algorithm: str
    parameters: Mapping[str, Any]
    evaluations: int | None
    seed: int
    out: Path
    overwrite: bool
    record: bool
    dry_run: bool


def run(request: Request, output: Output) -> int:
    """Do it; the exit code, as of `run_to_folder`."""
    with bad_input():
        check_flags(request.algorithm, request.parameters)
        prepared = prepare(
            request.problem,
            read_scenario(request.scenario),
            algorithm=request.algorithm,
            parameters=request.parameters,
            evaluations=request.evaluations,
            seed=request.seed,
        )
        persistence = RunPersistence(
            request.out, prepared.configuration, prepared.algorithm, record=request.record
        )
        check_folder(request.out, overwrite=request.overwrite)
        if not request.dry_run:
            request.out.mkdir(parents=True, exist_ok=True)
    if request.dry_run:
        describe_run(prepared, persistence, output)
        return ExitCode.DONE
    return run_to_folder(prepared, persistence, output, overwrite=request.overwrite)


def check_flags(algorithm: str, parameters: Mapping[str, Any]) -> None:
    """Refuse flags that the algorithm does not take, in terms of flags.

    Raises
    ------
    ValueError
        Naming the flag and those the algorithm takes.
    """
    known = complete_parameters(algorithm, {})
    for key in parameters:
        if key not in known:
            flags = ", ".join(map(flag, known))
            raise ValueError(f"{flag(key)} does not apply to {algorithm}, which takes {flags}")
