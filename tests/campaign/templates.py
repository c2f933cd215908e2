"""Good files to spoil, made once per process."""

from __future__ import annotations

import contextlib
import os
import tempfile
from functools import cache
from pathlib import Path

from typer.testing import CliRunner

from mgeo.cli.app import app

from .harness import Box, snapshot

SCENARIO = """\
preset = "paper"
duration = 600.0
step = 20.0

[convergence]
window = 100.0

[maneuvers]
count = 2
max_duration = 200.0
"""

STUDY = """\
title = "small"
evaluations = 24
seeds = [1, 2]
grid = 3

[[problems]]
name = "pymoo:zdt1"
options = { n_var = 4 }

[[algorithms]]
name = "mgeo-real"
label = "MGEO {sigma}"
sigma = [0.1, 0.2]
n_walkers = 2

[[algorithms]]
name = "nsga2"
population = 8

[published]
source = "nobody"
table = { "nsga2" = { "hypervolume" = 0.5 } }
"""

_COMMANDS = {
    "run": ("solve", "zdt1", "--runs", "2", "--evaluations", "120", "--record"),
    "begun": ("solve", "cantilever", "--runs", "2", "--evaluations", "20", "--record"),
    "attitude": ("solve", "attitude", "--scenario", "../scenario.toml", "--runs", "2",
                 "--evaluations", "48"),
}  # fmt: skip


@cache
def contents(name: str) -> dict[str, object]:
    """Files of a template: "run", "begun", "attitude" (run folders), "study" or "plans"."""
    before = os.getcwd()
    with tempfile.TemporaryDirectory() as place:
        os.chdir(place)
        try:
            Path("scenario.toml").write_text(SCENARIO)
            Path("work").mkdir()
            with contextlib.chdir("work"):
                _make(name)
            return snapshot(Path(place, "work"))
        finally:
            os.chdir(before)


def put(box: Box, name: str, folder: str = "") -> Path:
    """Write a template into the box; its folder."""
    place = box.work / (folder or name)
    place.mkdir(parents=True)
    for path, content in contents(name).items():
        target = place / path
        if isinstance(content, bytes):
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
    return place.relative_to(box.work)


def _make(name: str) -> None:
    if name == "study":
        Path("study.toml").write_text(STUDY)
        _invoke("study", "study.toml", "--out", "out", "--jobs", "1", "-q")
    elif name == "plans":
        _write("attitude")
        _invoke("attitude", "export", "attitude", "plan.json")
    else:
        _invoke(*_COMMANDS[name], "--out", ".", "-q")


def _write(name: str) -> None:
    for path, content in contents(name).items():
        target = Path(name, path)
        target.parent.mkdir(parents=True, exist_ok=True)
        if isinstance(content, bytes):
            target.write_bytes(content)


def _invoke(*arguments: str) -> None:
    done = CliRunner().invoke(app, arguments)
    if done.exit_code != 0:
        raise RuntimeError(f"mgeo {' '.join(arguments)}: {done.output}") from done.exception
