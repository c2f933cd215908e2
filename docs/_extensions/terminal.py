"""Cell magics that run the commands of a page, and show the commands with their output.

``%%terminal`` runs each line of a cell in a pseudo-terminal, and ``%%save NAME`` writes the cell to
a file. Both display the cell, so that the page can hide its input. A command ``mgeo`` runs in a
fork of a process that has already imported the modules of the commands, which is faster. All other
commands, and commands after a pipe, run in a shell.
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
#: Control sequence that colorama writes to a terminal when a program ends.
_RESET = "\x1b[0m"


def load_ipython_extension(shell: Any) -> None:
    """Register both magics, and change to a temporary folder."""
    from IPython.core.magic import register_cell_magic

    sys.path.insert(0, str(Path(__file__).resolve().parent))  # valid in the temporary folder, too
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
    """Run the commands of a cell, and show them with their output. Commands of ``%%terminal fails``
    must fail.
    """
    lines = cell.splitlines()
    shown = "\n".join(run_command(line, options == "fails") for line in lines).rstrip()
    _show(("sh", cell.strip()), *([("text", shown)] if shown else []))


def save(name: str, cell: str) -> None:
    """Write a cell to a file, and show the name and content of the file."""
    Path(name).write_text(cell, encoding="utf-8")
    _show((Path(name).suffix[1:], cell.strip()), caption=f"`{name}`:\n\n")


def run_command(command: str, fails: bool = False) -> str:
    """Run a command, and return its output on stdout. If the command is expected to fail, append
    the output on stderr.

    Raises
    ------
    RuntimeError
        If the command fails unexpectedly, or succeeds although it is expected to fail.
    """
    if _SMALL:
        command = re.sub(r"(?<=--evaluations )\d+", "960", command)
        command = command.replace("attitude verify", "attitude verify --monte-carlo 20")
    outside, inside = pty.openpty()
    fcntl.ioctl(inside, termios.TIOCSWINSZ, struct.pack("4H", 50, _COLUMNS, 0, 0))
    with ThreadPoolExecutor(1) as reader, tempfile.NamedTemporaryFile("w+") as messages:
        reading = reader.submit(lambda: b"".join(iter(lambda: _read(outside), b"")))
        code = _run(command, os.ttyname(inside), messages.name)
        os.close(inside)  # ends the reading
        output = reading.result()
        os.close(outside)
        # A plan of a short search may not achieve its predicted accuracy (exit code 3).
        if fails != (code != 0) and not (_SMALL and code == 3):
            raise RuntimeError(f"{command}\n{messages.read()}")
        if fails:
            output += messages.read().encode()
    lines = output.decode().replace(_RESET, "").splitlines()
    return "\n".join(line.rstrip() for line in lines) + "\n"


def _run(command: str, terminal: str, messages: str) -> int | None:
    """Run a command with these files as stdout and stderr, and return its exit code."""
    first, *piped = command.split(" | ", 1)
    program, *arguments = shlex.split(first)
    with open(terminal, "wb") as stdout, open(messages, "wb") as stderr:
        if program != "mgeo" or set(first) & set("|&;<>$`*?"):
            return subprocess.run(
                command, shell=True, stdout=stdout, stderr=stderr, check=False
            ).returncode
        with tempfile.NamedTemporaryFile() as between:
            output = between.name if piped else terminal
            process = _FORKS.Process(target=_run_mgeo, args=(arguments, output, messages))
            process.start()
            process.join()
            if piped:
                subprocess.run(piped[0], shell=True, stdin=between, stdout=stdout, check=True)
        return process.exitcode


def _run_mgeo(arguments: list[str], terminal: str, messages: str) -> None:
    """Run the command ``mgeo`` in this process, which ends with the command."""
    from mgeo.cli.app import main

    if _SMALL:
        import few_runs  # noqa: F401
    for number, path in ((1, terminal), (2, messages)):
        os.dup2(os.open(path, os.O_WRONLY | os.O_NOCTTY), number)
    sys.argv = ["mgeo", *arguments]
    main()


def _read(terminal: int) -> bytes:
    try:
        return os.read(terminal, 65_536)
    except OSError:  # Linux raises this error when the other end is closed.
        return b""


def _show(*blocks: tuple[str, str], caption: str = "") -> None:
    from IPython.display import display

    text = "\n\n".join(f"```{language}\n{text}\n```" for language, text in blocks)
    display({"text/markdown": caption + text}, raw=True)
