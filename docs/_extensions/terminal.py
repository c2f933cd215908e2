"""Pages whose cells are commands: each is run as a person would, and shown with what it prints.

The cell magic ``%%terminal`` runs the lines of a cell in a terminal of its own; ``%%save NAME``
writes a file. Both show the cell as it would be typed, so that the cell itself can be left out.
A line of ``mgeo`` runs in a fork of a process that has imported what commands import, all other
lines, and what a line of ``mgeo`` is piped into, in a shell.
"""

import fcntl
import multiprocessing
import os
import pty
import re
import shlex
import struct
import subprocess
import sys
import tempfile
import termios
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

_COLUMNS = 88
_SMALL = "MGEO_NOTEBOOK_SMALL" in os.environ
_FORKS = multiprocessing.get_context("forkserver")
_IMPORTED = [
    "mgeo.cli.app",
    "mgeo_calibration.commands.calibrate",
    "mgeo_calibration.commands.verify",
]
#: What colorama writes to a terminal when a program ends that has loaded it.
_RESET = "\x1b[0m"


def load_ipython_extension(shell: Any) -> None:
    """Register both magics, and work in a folder that nobody else sees."""
    from IPython.core.magic import register_cell_magic

    sys.path.insert(0, str(Path(__file__).resolve().parent))  # wherever one then works
    folder = tempfile.TemporaryDirectory()
    shell.user_ns["_folder"] = folder  # deleted with the kernel
    os.chdir(folder.name)
    os.environ.pop("CI", None)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    os.environ.update(PATH=path, TERM="dumb", NO_COLOR="1")
    _FORKS.set_forkserver_preload(_IMPORTED)
    register_cell_magic("terminal")(terminal)
    register_cell_magic("save")(save)


def terminal(options: str, cell: str) -> None:
    """Run commands, and show them and what they print; those of ``%%terminal fails`` must fail."""
    lines = cell.splitlines()
    shown = "\n".join(printed(line, options == "fails") for line in lines).rstrip()
    _show(("sh", cell.strip()), *([("text", shown)] if shown else []))


def save(name: str, cell: str) -> None:
    """Write a file, and show it."""
    Path(name).write_text(cell, encoding="utf-8")
    _show((Path(name).suffix[1:], cell.strip()))


def printed(command: str, fails: bool = False) -> str:
    """What a command writes to a terminal; messages on stderr only if it is expected to fail."""
    if _SMALL:
        command = re.sub(r"(?<=--evaluations )\d+", "960", command)
        command = command.replace("attitude verify", "attitude verify --monte-carlo 20")
    outside, inside = pty.openpty()
    fcntl.ioctl(inside, termios.TIOCSWINSZ, struct.pack("4H", 50, _COLUMNS, 0, 0))
    with ThreadPoolExecutor(1) as reader, tempfile.NamedTemporaryFile("w+") as messages:
        reading = reader.submit(lambda: b"".join(iter(lambda: _read(outside), b"")))
        code = _run(command, os.ttyname(inside), messages.name)
        os.close(inside)  # nobody writes any more
        written = reading.result()
        os.close(outside)
        # A short search may find a plan that does not keep its promise.
        if fails != (code != 0) and not (_SMALL and code == 3):
            raise RuntimeError(f"{command}\n{messages.read()}")
        if fails:
            written += messages.read().encode()
    lines = written.decode().replace(_RESET, "").splitlines()
    return "\n".join(line.rstrip() for line in lines) + "\n"


def _run(command: str, terminal: str, messages: str) -> int | None:
    """Exit code of a command whose stdout and stderr are these files."""
    asked, *piped = command.split(" | ", 1)
    program, *arguments = shlex.split(asked)
    with open(terminal, "wb") as stdout, open(messages, "wb") as stderr:
        if program != "mgeo" or set(asked) & set("|&;<>$`*?"):
            return subprocess.run(
                command, shell=True, stdout=stdout, stderr=stderr, check=False
            ).returncode
        with tempfile.NamedTemporaryFile() as between:
            written = between.name if piped else terminal
            process = _FORKS.Process(target=_mgeo, args=(arguments, written, messages))
            process.start()
            process.join()
            if piped:
                subprocess.run(piped[0], shell=True, stdin=between, stdout=stdout, check=True)
        return process.exitcode


def _mgeo(arguments: list[str], terminal: str, messages: str) -> None:
    """The command ``mgeo``, in a process that ends with it."""
    from mgeo.cli.app import main

    if _SMALL:
        import few_flights  # noqa: F401
    for number, path in ((1, terminal), (2, messages)):
        os.dup2(os.open(path, os.O_WRONLY | os.O_NOCTTY), number)
    sys.argv = ["mgeo", *arguments]
    main()


def _read(terminal: int) -> bytes:
    try:
        return os.read(terminal, 65_536)
    except OSError:  # so Linux says that nobody writes any more
        return b""


def _show(*blocks: tuple[str, str]) -> None:
    from IPython.display import display

    text = "\n\n".join(f"```{language}\n{text}\n```" for language, text in blocks)
    display({"text/markdown": text}, raw=True)
