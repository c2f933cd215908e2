"""Paths that are not what they seem, folders without permission, disks without room, clocks."""

from __future__ import annotations

import codecs
import contextlib
import importlib
import itertools
import os
import pkgutil
import resource
import shutil
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from unittest.mock import patch

import mgeo
from mgeo.runs.resume import resume_run
from mgeo.store.atomic import lock
from mgeo.store.run_folder import read_run

from .harness import Attempt, Box, kind
from .mutations import ESCAPES
from .run_folders import RESUME_WRITES
from .templates import put

NOBODY = 65534
SHORT = ["--walkers", "2", "--evaluations", "8", "-q"]

_NAMES = [
    "none", "none/deeper", "", ".", "..", "a\x00b", "x" * 250, "x" * 300, "x/" * 2500, "two\nlines",
    ESCAPES, "\udcff", " ", "~", "file", "file/below", "dangling", "loop", "loop/below", "fifo",
    "things", "to-elsewhere", "to-precious", "things/../things", "run/run.json", "run/front.csv",
    "run/run.checkpoint", "../elsewhere", "../elsewhere/precious.txt",
]  # fmt: skip


def _furnish(box: Box) -> None:
    Path("file").write_text("a file\n")
    Path("things").mkdir()
    Path("things/one").write_text("one\n")
    Path("dangling").symlink_to("nowhere")
    Path("loop").symlink_to("loop")
    Path("to-elsewhere").symlink_to(box.elsewhere)
    Path("to-precious").symlink_to(box.elsewhere / "precious.txt")
    os.mkfifo("fifo")
    put(box, "run")


@kind(weight=6)
def strange_path(box: Box) -> Attempt:
    """Where a command is told to read or write."""
    _furnish(box)
    name = box.pick(_NAMES)
    run = SHORT
    suffix = box.pick([".json", ".csv", ".aem", ""])
    if box.chance(0.3):
        put(box, "plans")
    actions = [
        ["mgeo", "solve", "cantilever", *run, "--out", name],
        ["mgeo", "solve", "cantilever", *run, "--out", "made", "--scenario", name],
        ["mgeo", "solve", "cantilever", *run, "--out", "made", "--scenario", f"{name}.toml"],
        ["mgeo", "resume", "-q", "--", name],
        ["mgeo", "report", "-q", "--", name],
        ["mgeo", "report", "run", "-q", "--out", name],
        ["mgeo", "report", "run", "-q", "--out", f"{name}.html"],
        ["mgeo", "study", "-q", "--out", "made", "--", name],
        ["mgeo", "attitude", "show", "--", name],
        ["mgeo", "attitude", "verify", "plans/plan.json", "--runs", "2", "--json", name],
        ["mgeo", "attitude", "export", "plans/plan.json", "--", name + suffix],
        ["mgeo", "attitude", "show", "plans/plan.json", "--html", name],
    ]
    # a run is put into a new place or an empty folder; nothing that is there may change
    return Attempt(box.pick(actions), creates=("*",), codes=(0, 3))


@kind(weight=4)
def strange_entry(box: Box) -> Attempt:
    """A run folder in which a file is a folder, a link or a mountain."""
    folder = put(box, box.pick(["run", "attitude"]), "run")
    names = ["run.json", "front.csv", "run.checkpoint", "evaluations", "evaluations/000000001.npz",
             "verification.json", "front.html", "report.html"]  # fmt: skip
    path = folder / box.pick([name for name in names if (folder / name).parent.is_dir()])
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
    what = box.pick(["nothing", "folder", "dangling", "loop", "precious", "huge"])
    box.note(f"{path} is {what}")
    target = {"dangling": "nowhere", "loop": path.name,
              "precious": str(box.elsewhere / "precious.txt")}  # fmt: skip
    if what == "folder":
        path.mkdir()
    elif what == "huge":
        path.touch()
        path.chmod(0o600)
    elif what in target:
        path.symlink_to(target[what])
    big = _huge(path) if what == "huge" else contextlib.nullcontext()
    actions = [
        ["mgeo", "report", "run", "-q"],
        ["mgeo", "resume", "run", "-q", "--evaluations", "180"],
        ["mgeo", "attitude", "export", "run", "plan.csv"],
    ]
    action = box.pick(actions)
    # a run that is longer is kept, also if its picture cannot be
    progress = RESUME_WRITES if action[1] == "resume" else ()
    return Attempt(action, writes=("work/run/*", "work/plan.csv"), around=big, progress=progress)


@contextlib.contextmanager
def _huge(path: Path) -> Iterator[None]:
    """A file of a tebibyte, of which nothing is on the disk."""
    os.truncate(path, 2**40)
    try:
        yield
    finally:
        with contextlib.suppress(FileNotFoundError):
            if path.stat().st_size == 2**40:
                os.truncate(path, 0)


@cache
def _load_all() -> None:
    """Import every module of mgeo, which others than the superuser need not be able to read."""
    for module in pkgutil.walk_packages(mgeo.__path__, "mgeo."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    for codec in ("unicode-escape", "cp437"):  # of Jinja's first template, of names in a zip file
        codecs.lookup(codec)  # what could not be imported once is unknown to the process forever


@contextlib.contextmanager
def _unprivileged(path: Path, mode: int) -> Iterator[None]:
    """Without the rights of the superuser, and with `mode` on a path."""
    superuser = os.geteuid() == 0
    before = path.stat().st_mode
    if superuser:
        _load_all()
        for entry in [Path(), *Path().rglob("*")]:
            os.chown(entry, NOBODY, NOBODY, follow_symlinks=False)
    path.chmod(mode)
    if superuser:
        os.seteuid(NOBODY)
    try:
        yield
    finally:
        if superuser:
            os.seteuid(0)
        if path.exists():
            path.chmod(before)


@kind(weight=4)
def no_permission(box: Box) -> Attempt:
    folder = put(box, "run")
    paths = [folder, *sorted(folder.rglob("*"))]
    path = box.pick(paths)
    mode = box.pick([0o000, 0o500, 0o400, 0o300] if path.is_dir() else [0o000, 0o200, 0o400])
    box.note(f"{path} has mode {mode:o}")
    actions = [
        ["mgeo", "report", "run", "-q"],
        ["mgeo", "resume", "run", "-q", "--evaluations", "180"],
        ["mgeo", "solve", "cantilever", *SHORT, "--out", "run"],
        ["mgeo", "solve", "cantilever", *SHORT, "--out", "run/below"],
    ]
    around = _unprivileged(path, mode)
    return Attempt(box.pick(actions), writes=("work/run/*",), around=around,
                   progress=("work/run/run.checkpoint", "work/run/evaluations/*"))  # fmt: skip


@contextlib.contextmanager
def _disk_of(size: int) -> Iterator[None]:
    """No file grows beyond so many bytes: writing fails there as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@kind(weight=2)
def disk_full(box: Box) -> Attempt:
    """After any number of bytes; what is half done may stay, but all that stays can be used."""
    folder = put(box, "run")
    size = int(box.rng.choice([0, 1, int(box.rng.integers(5000)), int(box.rng.integers(40_000))]))
    box.note(f"files of {size} bytes at most")
    run = ["--walkers", "2", "--evaluations", "24", "-q", "--record"]
    again = ["mgeo", "solve", "zdt1", *run, "--out", "run", "--overwrite"]
    longer = ["mgeo", "resume", "run", "-q", "--evaluations", "180"]
    new = ["mgeo", "solve", "zdt1", *run, "--out", "made"]
    action = box.pick([again, longer, new, ["mgeo", "report", "run", "-q"]])

    def usable() -> None:
        if (folder / "run.json").exists():
            read_run(folder)
        if (folder / "run.checkpoint").exists():
            resume_run(folder)

    written = ("work/run/*", "work/made/*")
    return Attempt(action, writes=written, around=_disk_of(size),
                   progress=written if action[1] != "report" else (), always=usable)  # fmt: skip


@contextlib.contextmanager
def _clock_going_back(box: Box) -> Iterator[None]:
    real = time.time
    jumps = box.rng.choice([0.0, 1.0, 3600.0, 1e9], size=1000) * box.rng.random(1000)
    calls = itertools.count()
    with patch.object(time, "time", lambda: real() - jumps[next(calls) % len(jumps)]):
        yield


@kind(weight=0.7)
def clock_going_back(box: Box) -> Attempt:
    put(box, "run")
    action = box.pick([
        ["mgeo", "resume", "run", "--evaluations", "192"],
        ["mgeo", "solve", "cantilever", "--algorithm", "mgeo-real", "--out", "made", "--record",
         "--walkers", "2", "--evaluations", "24"],
    ])  # fmt: skip

    def sound(ran: object) -> None:
        assert getattr(ran, "exit_code", None) == 0
        run = read_run(action[2] if action[1] == "resume" else "made")
        assert run.outcome.evaluations == (192 if action[1] == "resume" else 24)
        assert run.outcome.wall_time_s >= 0.0

    return Attempt(action, writes=("work/*",), sound=sound, around=_clock_going_back(box))


@kind(weight=1)
def two_commands(box: Box) -> Attempt:
    """Another process is at work in the folder."""
    folder = put(box, "run")
    action = box.pick([
        ["mgeo", "resume", "run", "--evaluations", "180", "-q"],
        ["mgeo", "solve", "zdt1", "--out", "run", "--overwrite", *SHORT],
    ])  # fmt: skip
    return Attempt(action, ("run is in use",), around=lock(folder), codes=())
