"""Plugins of which a part raises."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.plugins.discovery import PROBLEMS
from mgeo.store.run_folder import read_run

from . import faulty
from .harness import Attempt, Box, kind
from .mutations import ESCAPES

WRITES = ("work/made/*",)

#: Parts that raise, and values of the objectives with which a run must cope.
_PARTS = (
    *("construction", "options", "from_options", "indicator_space", "view", "describe", "answers"),
    *("limits", "front_summary", "figures", "solution_figures", "F"),
)
_OBJECTIVES = [
    lambda F: np.full_like(F, np.nan), lambda F: np.where(F > 4, np.nan, F),
    lambda F: np.where(F > 4, np.inf, F), lambda F: F * 1e300 * 1e300,
    lambda F: np.zeros_like(F), lambda F: F * 1e-320,
]  # fmt: skip

_RAISED = [
    ValueError("no license"), TypeError("two\nlines"), KeyError("key"), ZeroDivisionError(),
    RuntimeError(ESCAPES), AttributeError("x"), IndexError(), MemoryError(), RecursionError("deep"),
    AssertionError(), np.linalg.LinAlgError("singular"), ImportError("no module"),
    OSError(28, "full"),
    StopIteration(), UnicodeDecodeError("utf-8", b"x", 0, 1, "bad"), NotImplementedError(),
]  # fmt: skip


def _points(group: str = "") -> list[EntryPoint]:
    return [EntryPoint("faulty", f"{faulty.__name__}:Faulty", PROBLEMS)] * (group == PROBLEMS)


@contextlib.contextmanager
def spoiled_plugin(name: str, part: Any) -> Iterator[None]:
    """The one problem that is installed, ``faulty``, with a part that is as given."""
    with (
        patch.dict(faulty.PART, {name: part}, clear=True),
        patch("mgeo.plugins.discovery.metadata.entry_points", _points),
    ):
        yield


def _drawn(box: Box) -> tuple[str, Any]:
    name = box.pick(_PARTS)
    part = box.pick(_OBJECTIVES if name == "F" and box.chance(0.5) else _RAISED)
    box.note(f"{name} is {part!r:.200}")
    return name, part


@kind(weight=3)
def plugin_solved(box: Box) -> Attempt:
    around = spoiled_plugin(*_drawn(box))
    algorithm = box.pick(["mgeo-real", "mgeo-real", "mgeo-var", "nsga2", "random", "moead"])
    size = ["--walkers", "2"] if algorithm.startswith("mgeo") else ["--population", "8"]
    more = ["--record"] if box.chance(0.3) and algorithm != "moead" else []
    return Attempt(
        ["mgeo", "solve", "faulty", "--algorithm", algorithm, *size, "--evaluations", "8", *more,
         "--out", "made"],
        writes=WRITES, progress=WRITES, around=around, always=_usable,
    )  # fmt: skip


def _usable() -> None:
    """A run is not lost because its picture cannot be drawn."""
    if Path("made/run.json").exists():
        assert read_run("made").outcome.evaluations >= 8


@kind(weight=1)
def plugin_listed(box: Box) -> Attempt:
    return Attempt(["mgeo", "problems"], around=spoiled_plugin(*_drawn(box)))


@kind(weight=0.5)
def plugin_reported(box: Box) -> Attempt:
    """A sound run, of a plugin that is another one meanwhile."""
    with spoiled_plugin("none", None):
        solve = ["solve", "faulty", "--walkers", "2", "--evaluations", "8", "--out", "made", "-q"]
        done = CliRunner().invoke(app, solve)
    assert done.exit_code == 0, done.output
    return Attempt(["mgeo", "report", "made", "-q"], writes=("work/made/report.html",),
                   around=spoiled_plugin(*_drawn(box)))  # fmt: skip


@kind(weight=0.3)
def plugin_studied(box: Box) -> Attempt:
    Path("s.toml").write_text(
        'title = "t"\nevaluations = 8\nseeds = 1\ngrid = 2\n[[problems]]\nname = "faulty"\n'
        '[[algorithms]]\nname = "mgeo-real"\nn_walkers = 2\n'
    )
    return Attempt(["mgeo", "study", "s.toml", "--out", "made", "--jobs", "1", "-q"],
                   writes=WRITES, progress=("work/made/runs/*",),
                   around=spoiled_plugin(*_drawn(box)))  # fmt: skip
