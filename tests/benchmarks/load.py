"""A run of a million evaluations with a front of 50,000 points, and a study of 1,000 runs.

::

    python -m tests.benchmarks.load        # measures, and prints the table
"""

from __future__ import annotations

import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import astuple, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from unittest.mock import patch

from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.problems.many import DTLZ2
from pymoo.problems.multi import ZDT1

import mgeo
from mgeo import Checkpoint, MGEOReal
from mgeo.runs.solve import State
from mgeo.store.run import RunConfiguration
from mgeo.store.run_persistence import RunPersistence
from tests.mgeo.solved import solve

from .table import markdown, processor

EVALUATIONS, POINTS = 1_000_000, 20
RUNS = 1_000
PARAMETERS: dict[str, Any] = {"sigma": 0.1, "perturbation": "range"}
_MARK = "MGEO_LOAD"  # in the environment of all processes of a study
_GRACE = 5.0  # seconds that helpers of a process have to notice its end


@dataclass(frozen=True)
class Point:
    """Where a run stands, and how it went since the point before.

    Times are of the processor, in ms per generation: work, whoever else works. Memory is what is
    resident, in MiB, now and at most so far.
    """

    evaluations: int
    solutions: int
    generation_ms: float
    checkpoints_ms: float
    resident_mib: float
    peak_mib: float


@dataclass(frozen=True)
class Leftovers:
    """What a study leaves behind once its process has ended."""

    runs: int
    processes: tuple[str, ...]
    files: tuple[str, ...]
    shared_memory: tuple[str, ...]


class Watch:
    """Callback of a run that notes a `Point` every so many evaluations."""

    def __init__(self, every: int) -> None:
        self.points: list[Point] = []
        self._every = self._next = every
        self._begin()

    def __call__(self, state: State) -> None:
        self._generations += 1
        if state.evaluations < self._next:
            return
        spent = time.process_time() - self._start - self._checkpoints
        self.points.append(
            Point(
                state.evaluations,
                len(state.front()[1]),
                round(1e3 * spent / self._generations, 2),
                round(1e3 * self._checkpoints / self._generations, 2),
                round(_resident(), 1),
                round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, 1),
            )
        )
        self._next += self._every
        self._begin()

    def timed(self, write: Callable[..., None]) -> Callable[..., None]:
        """The method that writes checkpoints, with its time taken."""

        def timed_write(*arguments: Any) -> None:
            start = time.process_time()
            write(*arguments)
            self._checkpoints += time.process_time() - start

        return timed_write

    def _begin(self) -> None:
        self._checkpoints, self._generations = 0.0, 0
        self._start = time.process_time()


def run(folder: Path, evaluations: int, points: int = POINTS) -> list[Point]:
    """A run as ``mgeo solve --record`` makes it: with checkpoints, and every evaluation kept.

    The problem is cheap, and its front grows: to 50,000 points after a million evaluations.
    """
    algorithm = MGEOReal(**PARAMETERS)
    configuration = RunConfiguration(
        problem="dtlz2",
        options={},
        algorithm="mgeo-real",
        parameters=PARAMETERS,
        evaluations=evaluations,
        seed=1,
    )
    persistence = RunPersistence(folder, configuration, algorithm, record=True)
    watch = Watch(evaluations // points)
    with patch.object(Checkpoint, "write", watch.timed(Checkpoint.write)):
        solve(DTLZ2(n_var=6, n_obj=3), algorithm, evaluations, 1, watch, persistence)
    return watch.points


def study(folder: Path, runs: int) -> Leftovers:
    """A study in a process of its own, and what is left of it: in all there should be nothing.

    Its runs go to processes, are kept in `folder`, and last a few milliseconds each.
    """
    temporary = folder / "temporary"
    temporary.mkdir()
    before = _shared_memory()
    mark = f"{_MARK}={folder}"
    subprocess.run(
        [sys.executable, "-m", f"{__package__}.load", "study", folder / "study", str(runs)],
        env={**os.environ, _MARK: str(folder), "TMPDIR": str(temporary)},
        cwd=Path(__file__).parents[2],
        check=True,
    )
    deadline = time.monotonic() + _GRACE
    while time.monotonic() < deadline:
        processes, shared = _processes(mark), _orphans(_shared_memory() - before)
        if not processes and not shared:
            break
        time.sleep(0.1)
    return Leftovers(
        runs=len(list((folder / "study" / "runs").iterdir())),
        processes=tuple(processes),
        files=(
            *(path.name for path in (folder / "study").rglob("*.tmp")),
            *(path.name for path in temporary.rglob("*")),
        ),
        shared_memory=tuple(shared),
    )


def make_study(folder: Path, runs: int) -> None:
    """The runs themselves: two algorithms on a small problem, on two processes."""
    algorithms = {"MGEO_real": MGEOReal(0.1, perturbation="range"), "NSGA-II": NSGA2(20)}
    result = mgeo.compare(
        ZDT1(n_var=6), algorithms, 200, runs // 2, folder=folder, n_jobs=2, progress=False
    )
    if (result.runs["status"] != "finished").any():
        raise RuntimeError(f"runs failed: {set(result.runs['error'])}")


def _resident() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 2**20


def _shared_memory() -> set[str]:
    """Shared memory and named semaphores of all processes of the machine."""
    return {entry.name for entry in Path("/dev/shm").iterdir()}


def _orphans(names: set[str]) -> list[str]:
    """Those of no living process, by a number in the name or by use: others may run studies."""
    living = {entry for entry in Path("/proc").iterdir() if entry.name.isdigit()}
    numbers = {entry.name for entry in living}
    names = {name for name in names if not numbers & set(re.findall(r"\d+", name))}
    used = "".join(_text(entry / "maps") for entry in living) if names else ""
    return sorted(name for name in names if f"/dev/shm/{name}\n" not in used)


def _processes(mark: str) -> list[str]:
    """Command lines of the processes with this in their environment."""
    marked = [
        entry
        for entry in Path("/proc").iterdir()
        if entry.name.isdigit() and mark in _text(entry / "environ").split("\0")
    ]
    return [_text(entry / "cmdline").replace("\0", " ") for entry in marked]


def _text(path: Path) -> str:
    try:
        return path.read_text(errors="replace")
    except OSError:  # the process has ended, or belongs to somebody else
        return ""


def main() -> None:
    """Measure, and print what was found."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        points = run(folder, EVALUATIONS)
        (folder / "study").mkdir()
        left = study(folder / "study", RUNS)
    sys.stdout.write(tables(points, left) + "\n")


def tables(points: list[Point], left: Leftovers) -> str:
    """What was found, as Markdown."""
    head = (
        "evaluations",
        "points on the front",
        "generation [ms]",
        "checkpoints [ms]",
        "memory [MiB]",
        "at most [MiB]",
    )
    rows = [
        (f"{p.evaluations:,}", f"{p.solutions:,}", *map("{:.1f}".format, astuple(p)[2:]))
        for p in points
        if p.evaluations == points[0].evaluations or points.index(p) % 2
    ]
    python = ".".join(map(str, sys.version_info[:3]))
    return "\n\n".join(
        [
            f"{processor()}, Python {python}, {datetime.now(UTC):%Y-%m-%d}.",
            markdown(head, rows),
            f"Study: {left.runs:,} runs kept; processes left {len(left.processes)}, other files "
            f"{len(left.files)}, shared memory and semaphores {len(left.shared_memory)}.",
        ]
    )


if __name__ == "__main__":
    if sys.argv[1:2] == ["study"]:
        make_study(Path(sys.argv[2]), int(sys.argv[3]))
    else:
        main()
