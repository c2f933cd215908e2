"""One case: a folder with good files, something bad about them or the request, and a judgment."""

from __future__ import annotations

import contextlib
import os
import resource
import shutil
import signal
import stat
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import numpy as np
from typer.testing import CliRunner

from mgeo.cli.app import app

SEED = 20261121
SECONDS = 30  # after which a case counts as hanging
MEMORY = 2**31  # bytes more than the process has: a case must not bring down the machine
LONGEST = 1000  # characters of a message that a person reads
BAD_INPUT = 2
#: Of a search that ends and has found nothing feasible.
NOTHING_FEASIBLE = 3

# in memory where there is such a place: most of the time of a case is that of its folder
PLACE = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None

STAND_IN = str(Path(__file__).parent.parent / "mgeo" / "stand_in")


@dataclass
class Attempt:
    """What a case does, and what may come of it.

    `action` is a command as a list of arguments, or a function. Where that is refused, the
    message holds one of `mentions`. A success may create or change what matches `writes`, create
    what matches `creates`, and `sound` checks its result; what matches `progress` may change in
    any case, as by a run that ends early, and `always` checks what is there then. `codes` are exit
    codes of a command that did what it was asked; `around` is entered while it does.
    """

    action: list[str] | Callable[[], Any]
    mentions: Sequence[str] = ()
    writes: Sequence[str] = ()
    creates: Sequence[str] = ()
    progress: Sequence[str] = ()
    sound: Callable[[Any], object] = lambda result: None
    always: Callable[[], object] = lambda: None
    codes: Sequence[int] = (0,)
    around: contextlib.AbstractContextManager[Any] = field(default_factory=contextlib.nullcontext)


@dataclass
class Box:
    """Where a case takes place: `work` is the current folder; all of `root` is watched."""

    root: Path
    rng: np.random.Generator
    log: list[str] = field(default_factory=list)

    @property
    def work(self) -> Path:
        return self.root / "work"

    @property
    def elsewhere(self) -> Path:
        """A folder that the case has no business in."""
        return self.root / "elsewhere"

    def note(self, text: str) -> None:
        self.log.append(text)

    def pick(self, choices: Sequence[Any]) -> Any:
        """One of them."""
        return choices[int(self.rng.integers(len(choices)))]

    def chance(self, probability: float) -> bool:
        return bool(self.rng.random() < probability)


@dataclass(frozen=True)
class Result:
    """How a case went: `failures` is empty if it went as it should."""

    number: int
    kind: str
    refused: bool
    failures: list[str]
    log: list[str]
    said: str


Maker = Callable[[Box], Attempt]
KINDS: dict[str, tuple[float, Maker]] = {}


def kind(weight: float) -> Callable[[Maker], Maker]:
    """Register what makes cases of one kind, so many of them relative to the others."""

    def register(maker: Maker) -> Maker:
        KINDS[maker.__name__.replace("_", " ")] = (weight, maker)
        return maker

    return register


@contextlib.contextmanager
def _stand_in() -> Iterator[None]:
    """Make the problems of the tests' stand-in plugin known to this process meanwhile."""
    sys.path.insert(0, STAND_IN)
    try:
        yield
    finally:
        sys.path.remove(STAND_IN)


def run_case(number: int, among: Sequence[str] = (), keep: bool = False) -> Result:
    """Make a case and judge it; it is of one of some kinds, if any are given."""
    rng = np.random.default_rng([SEED, number])
    names = list(among) or list(KINDS)
    weights = np.array([KINDS[name][0] for name in names])
    name = names[int(rng.choice(len(names), p=weights / weights.sum()))]
    root = Path(tempfile.mkdtemp(prefix=f"campaign-{number}-", dir=PLACE))
    box = Box(root, rng)
    before = Path.cwd()
    try:
        for folder in (box.work, box.elsewhere):
            folder.mkdir()
        (box.elsewhere / "precious.txt").write_text("do not touch\n")
        root.chmod(0o711)
        os.chdir(box.work)
        with _stand_in():
            attempt = KINDS[name][1](box)
            return _judged(number, name, box, attempt)
    finally:
        os.chdir(before)
        if keep:
            print(f"kept: {root}")
        else:
            shutil.rmtree(root, ignore_errors=True)


def snapshot(root: Path) -> dict[str, Any]:
    """Every entry below a folder: content of files, target of links, kind of anything else."""
    found: dict[str, Any] = {}
    for folder, folders, files in os.walk(root):
        for name in [*folders, *files]:
            path = os.path.join(folder, name)
            mode = os.lstat(path).st_mode
            if stat.S_ISREG(mode):
                with open(path, "rb") as file:
                    content: Any = file.read()
            elif stat.S_ISLNK(mode):
                content = ("link", os.readlink(path))
            else:
                content = ("other", stat.S_IFMT(mode))
            found[os.path.relpath(path, root)] = content
    return found


def _judged(number: int, name: str, box: Box, attempt: Attempt) -> Result:
    before = snapshot(box.root)
    failures: list[str] = []
    command = isinstance(attempt.action, list)
    with attempt.around, _alarm(), _memory(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        refused, said, result = (_command if command else _function)(attempt, failures)
    after = snapshot(box.root)
    if command and isinstance(attempt.action, list):
        box.note("$ " + " ".join(map(repr, attempt.action)))
    failures += _damage(before, after, attempt, refused)
    if refused:
        failures += _faults(said, attempt.mentions)
    if not failures:
        try:
            attempt.always()
            if not refused:
                attempt.sound(result)
        except Exception:
            failures.append(f"the result is not sound: {traceback.format_exc()}")
    return Result(number, name, refused, failures, box.log, said)


def _command(attempt: Attempt, failures: list[str]) -> tuple[bool, str, Any]:
    _, *arguments = attempt.action  # type: ignore[misc]
    ran = CliRunner().invoke(app, arguments, prog_name="mgeo")
    shown = ran.stdout + ran.stderr
    if ran.exception is not None and not isinstance(ran.exception, SystemExit):
        failures.append("".join(traceback.format_exception(ran.exception)))
    elif ran.exit_code not in (BAD_INPUT, *attempt.codes) and not (
        ran.exit_code == NOTHING_FEASIBLE and arguments[0] in ("solve", "resume")
    ):
        failures.append(f"exit code {ran.exit_code}: {shown}")
    if raw := _controls(shown):
        failures.append(f"raw control characters {raw!r} on the terminal: {shown!r}")
    if ran.exit_code != BAD_INPUT:
        return False, shown, ran
    lines = ran.stderr.splitlines()
    if not lines:
        failures.append("nothing is said on stderr")
        return True, "", ran
    if not lines[0].startswith("Usage: ") and sum(line.startswith("Error: ") for line in lines) > 1:
        failures.append(f"more than one error: {ran.stderr!r}")
    return True, _message(ran.stderr), ran


def _message(stderr: str) -> str:
    """The error in what a command said: of wrong usage in a box, else its last line."""
    if stderr.startswith("Usage: "):
        return " ".join(stderr.split("\n", 2)[2].split())
    return stderr.splitlines()[-1]


def _function(attempt: Attempt, failures: list[str]) -> tuple[bool, str, Any]:
    try:
        return False, "", attempt.action()  # type: ignore[operator]
    except (ValueError, TypeError, OSError) as error:
        # as `mgeo` shows it: see mgeo.cli.errors
        return True, f"Error: {error}", None
    except Exception as error:
        failures.append("".join(traceback.format_exception(error)))
        return True, "", None


def _controls(text: str) -> str:
    allowed = "\n"
    return "".join(sorted({c for c in text if not c.isprintable() and c not in allowed}))


def _faults(said: str, mentions: Sequence[str]) -> list[str]:
    faults = []
    if said.startswith("Error: "):
        text = said.removeprefix("Error: ")
        if len(text) < 8 or (text[0] in "'\"" and text.strip("'\"").isidentifier()):
            faults.append(f"no cause is given: {said!r}")
        if mentions and not any(mention in text for mention in mentions):
            faults.append(f"none of {list(mentions)} is named: {said[:LONGEST]!r}")
    return faults


def _damage(
    before: dict[str, Any], after: dict[str, Any], attempt: Attempt, refused: bool
) -> list[str]:
    found = []
    for path in before.keys() | after.keys():
        allowed = [*attempt.progress, *([] if refused else attempt.writes)]
        if path not in before and not refused:
            allowed += attempt.creates
        if before.get(path) == after.get(path) or any(fnmatch(path, each) for each in allowed):
            continue
        if path not in before and not isinstance(after[path], bytes):
            continue  # an empty folder made on the way
        change = "is new" if path not in before else "is gone" if path not in after else "changed"
        found.append(f"damage: {path!r} {change}")
    return found


@contextlib.contextmanager
def _memory() -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    with open("/proc/self/statm") as file:
        used = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


@contextlib.contextmanager
def _alarm() -> Iterator[None]:
    def ring(number: int, frame: object) -> None:
        raise RuntimeError(f"hangs for {SECONDS} s")

    previous = signal.signal(signal.SIGALRM, ring)
    signal.alarm(SECONDS)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, previous)


__all__ = ["KINDS", "Attempt", "Box", "Result", "kind", "run_case", "snapshot"]
