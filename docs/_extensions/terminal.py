"""Pages whose cells are commands: each is run as a person would, and shown with what it prints.

The cell magic ``%%terminal`` runs the lines of a cell in a terminal of its own; ``%%save NAME``
writes a file. Both show the cell as it would be typed, so that the cell itself can be left out.
"""

import fcntl
import os
import pty
import re
import struct
import subprocess
import sys
import tempfile
import termios
from pathlib import Path
from typing import Any

from IPython.core.magic import register_cell_magic
from IPython.display import display

_COLUMNS = 88
#: What colorama writes to a terminal when a program ends that has loaded it.
_RESET = "\x1b[0m"


def load_ipython_extension(shell: Any) -> None:
    """Register both magics, and work in a folder that nobody else sees."""
    folder = tempfile.TemporaryDirectory()
    shell.user_ns["_folder"] = folder  # deleted with the kernel
    os.chdir(folder.name)
    register_cell_magic("terminal")(terminal)
    register_cell_magic("save")(save)


def terminal(options: str, cell: str) -> None:
    """Run commands, and show them and what they print."""
    lines = cell.splitlines()
    shown = "\n".join(printed(line) for line in lines).rstrip()
    _show(("sh", cell.strip()), *([("text", shown)] if shown else []))


def save(name: str, cell: str) -> None:
    """Write a file, and show it."""
    Path(name).write_text(cell, encoding="utf-8")
    _show((Path(name).suffix[1:], cell.strip()))


def printed(command: str) -> str:
    """What a command writes to a terminal; messages on stderr only if it fails."""
    small = "MGEO_NOTEBOOK_SMALL" in os.environ
    if small:
        command = re.sub(r"(?<=--evaluations )\d+", "960", command)
    outside, inside = pty.openpty()
    fcntl.ioctl(inside, termios.TIOCSWINSZ, struct.pack("4H", 50, _COLUMNS, 0, 0))
    kept = {name: value for name, value in os.environ.items() if name != "CI"}
    path = f"{Path(sys.executable).parent}{os.pathsep}{kept['PATH']}"
    with tempfile.TemporaryFile("w+") as messages:
        process = subprocess.Popen(
            command,
            shell=True,
            stdout=inside,
            stderr=messages,
            env=kept | {"PATH": path, "TERM": "dumb", "NO_COLOR": "1"},
        )
        os.close(inside)
        written = b"".join(iter(lambda: _read(outside), b""))
        os.close(outside)
        # A short search may find a plan that does not keep its promise.
        if process.wait() not in ((0, 3) if small else (0,)):
            messages.seek(0)
            raise RuntimeError(f"{command}\n{messages.read()}")
    lines = written.decode().replace(_RESET, "").splitlines()
    return "\n".join(line.rstrip() for line in lines) + "\n"


def _read(terminal: int) -> bytes:
    try:
        return os.read(terminal, 65_536)
    except OSError:  # so Linux says that nobody writes any more
        return b""


def _show(*blocks: tuple[str, str]) -> None:
    text = "\n\n".join(f"```{language}\n{text}\n```" for language, text in blocks)
    display({"text/markdown": text}, raw=True)
