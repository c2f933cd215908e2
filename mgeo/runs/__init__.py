"""Runs: prepared from a configuration, saved in a folder, made again from it.

::

    run = prepare("attitude", algorithm="nsga2", seed=3)
    found = run.solve()
    write_run("runs/one", Run(run.configuration, found, installed_versions("attitude")))
    PreparedRun.of(read_run("runs/one").configuration).solve()  # the same front
"""

from mgeo.runs.configuration import RunConfiguration
from mgeo.runs.estimate import estimate
from mgeo.runs.folder import (
    FIGURE_FILE,
    FRONT_FILE,
    RUN_FILE,
    Run,
    check_folder,
    front_table,
    installed_versions,
    prepare_folder,
    read_run,
    run_document,
    write_figure,
    write_run,
)
from mgeo.runs.persistence import CHECKPOINT_FILE, RECORD_FOLDER, RunPersistence
from mgeo.runs.prepare import PreparedRun, prepare
from mgeo.runs.representative import RepresentativeSolution, representative_solutions
from mgeo.runs.resume import resume_run
from mgeo.runs.solve import Outcome, State, solve

__all__ = [
    "CHECKPOINT_FILE",
    "FIGURE_FILE",
    "FRONT_FILE",
    "RECORD_FOLDER",
    "RUN_FILE",
    "Outcome",
    "PreparedRun",
    "RepresentativeSolution",
    "Run",
    "RunConfiguration",
    "RunPersistence",
    "State",
    "check_folder",
    "estimate",
    "front_table",
    "installed_versions",
    "prepare",
    "prepare_folder",
    "read_run",
    "representative_solutions",
    "resume_run",
    "run_document",
    "solve",
    "write_figure",
    "write_run",
]
