"""Runs: made from a recipe, kept in a folder, made again from it.

::

    run = prepare("attitude", algorithm="nsga2", seed=3)
    outcome = run.solve()
    write_run("runs/one", Run(run.recipe, outcome, installed_versions("attitude")))
    read_run("runs/one").recipe.prepare().solve()  # the same front
"""

from mgeo.runs.estimate import Estimate, estimate
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
from mgeo.runs.highlights import Highlight, highlights
from mgeo.runs.hypervolume import Hypervolume
from mgeo.runs.keep import CHECKPOINT_FILE, RECORD_FOLDER, Keeper
from mgeo.runs.recipe import PreparedRun, Recipe, prepare
from mgeo.runs.resume import ResumedRun, resume_run
from mgeo.runs.solve import Outcome, State, solve

__all__ = [
    "CHECKPOINT_FILE",
    "FIGURE_FILE",
    "FRONT_FILE",
    "RECORD_FOLDER",
    "RUN_FILE",
    "Estimate",
    "Highlight",
    "Hypervolume",
    "Keeper",
    "Outcome",
    "PreparedRun",
    "Recipe",
    "ResumedRun",
    "Run",
    "State",
    "check_folder",
    "estimate",
    "front_table",
    "highlights",
    "installed_versions",
    "prepare",
    "prepare_folder",
    "read_run",
    "resume_run",
    "run_document",
    "solve",
    "write_figure",
    "write_run",
]
