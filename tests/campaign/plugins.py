"""Plugins that break the plugin protocol."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pandas as pd
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.plugins.discovery import PROBLEMS
from mgeo.store.run_folder import read_run

from . import faulty
from .harness import Attempt, Box, kind
from .mutations import ESCAPES, nasty

WRITES = ("work/made/*",)

_SPECIAL: dict[str, list[Any]] = {
    "n_var": [0, -1, 2.0, "2", None, 3],
    "n_obj": [0, -1, 2.0, "2", None, 3, 1],
    "n_ieq_constr": [-1, "1", None, 1, 2.5],
    "xl": [np.nan, [np.nan, 0], [4, 4], [-np.inf, 0], [0], [0, 0, 0], "low", [[-1, -1]], None, 10],
    "xu": [np.nan, [np.nan, 0], [-4, -4], [np.inf, 0], [0], [0, 0, 0], "high", [[1, 1]], None],
    "var_names": [["a"], ["a", "a"], 5, None, "xy", ["a [s]", "b"], [ESCAPES, "y"], [1, 2],
                  [[], {}]],
    "obj_names": [["a"], ["a", "a"], 5, None, "ab", ["x [m]", "b"], [ESCAPES, "b"], [1, 2]],
    "F": [None, 5.0, np.zeros(3), "x", lambda F: F[:, :1], lambda F: F.T, lambda F: F[:-1],
          lambda F: np.full_like(F, np.nan), lambda F: np.where(F > 4, np.nan, F),
          lambda F: np.where(F > 4, np.inf, F), lambda F: F.astype(str), lambda F: F * 1j,
          lambda F: F.astype(object), lambda F: F * 1e300 * 1e300, lambda F: F.tolist(),
          lambda F: np.zeros_like(F), lambda F: F * 1e-320],
    "G": [None, np.zeros(3), "x", np.nan],
    "indicator_space": [None, np.zeros(3), lambda F: F[:1], lambda F: F[:, :1], "x",
                        lambda F: np.full(np.shape(F), np.nan), lambda F: np.asarray(F) * np.inf,
                        lambda F: np.asarray(F).tolist(), lambda F: np.asarray(F).astype(str)],
    "describe": [None, {}, pd.DataFrame(), pd.DataFrame({"x": []}), pd.DataFrame({"x": [1]}), "x",
                 pd.DataFrame({ESCAPES: ["\x1b[31m"] * 3}), [1, 2, 3]],
    "answers": [None, [], "x", [1], [""], {"a": "b"}, [ESCAPES], np.array(["a"])],
    "limits": [None, [], "x", [1], [pd.DataFrame()], [pd.DataFrame({"unit": ["m"]})]],
    "front_summary": [None, [], "x", {"points": ESCAPES}, {1: 2}],
    "figures": [None, [], {}, {"front": None}, {"front": 5}, {"front": "<script>"}],
    "solution_figures": [None, [], [{}], 5, [None], "x"],
    "options": [None, 5, [], {"a": np.zeros(2)}, {"a": float("nan")}, {"a": object()}, {1: 2},
                "x"],
    "from_options": [None, 5, lambda: None, lambda: 5, lambda: object()],
    "construction": [],
}  # fmt: skip

_RAISED = [
    ValueError("no license"), TypeError("two\nlines"), KeyError("key"), ZeroDivisionError(),
    RuntimeError(ESCAPES), AttributeError("x"), IndexError(), MemoryError(), RecursionError("deep"),
    AssertionError(), np.linalg.LinAlgError("singular"), ImportError("no module"),
    OSError(28, "full"),
    StopIteration(), UnicodeDecodeError("utf-8", b"x", 0, 1, "bad"), NotImplementedError(),
]  # fmt: skip


def _point(name: str) -> list[EntryPoint]:
    return [EntryPoint(name, f"{faulty.__name__}:Faulty", PROBLEMS)]


@contextlib.contextmanager
def spoiled_plugin(name: str, part: Any) -> Iterator[None]:
    """The one problem that is installed, ``faulty``, with a part that is as given."""
    with (
        patch.dict(faulty.PART, {name: part}, clear=True),
        patch("mgeo.plugins.discovery.entry_points", lambda group: _point("faulty")),
    ):
        yield


def _drawn(box: Box) -> tuple[str, Any]:
    name = box.pick(list(_SPECIAL))
    special = _SPECIAL[name]
    part = box.pick(_RAISED) if not special or box.chance(0.35) else box.pick(special)
    if special and box.chance(0.15):
        part = nasty(box)
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
