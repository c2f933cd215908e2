"""``mgeo new``: a package with a problem, its view, its tests and a README, to be changed.

The example in it is complete: a steel cantilever with a load at its end.
"""

from __future__ import annotations

import importlib.util
import keyword
import os
import re
import secrets
import shutil
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer

from mgeo.cli import options
from mgeo.cli.errors import bad_input
from mgeo.cli.output import Output
from mgeo.plugins.discovery import COMMANDS, PROBLEMS, installed_plugins

_NAME = re.compile(r"[a-z][a-z0-9]*([-_][a-z0-9]+)*")
_FILES = {
    "pyproject.toml": "pyproject.toml",
    "README.md": "README.md",
    "{module}/__init__.py": "init.py",
    "{module}/problem.py": "problem.py",
    "{module}/view.py": "view.py",
    "tests/test_{module}.py": "test.py",
}


def problem(
    name: Annotated[
        str, typer.Argument(help="What the problem is called, in lower case: my-beam.")
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="New folder to write [default: NAME].")
    ] = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Write a problem of your own: a package with problem, view, test and README.

    It is complete, a cantilever that is to be light or stiff, installs, passes its tests and is
    solved by its name; change it into yours file by file.
    """
    output = Output(quiet, json)
    with bad_input():
        files = write_problem(name, out)
    folder = out or Path(name)
    output.print(*(f"written: {file}" for file in files))
    output.print(f"next: pip install -e {folder}, then mgeo solve {name} --evaluations 6000")
    output.result({"folder": str(folder), "files": [str(file) for file in files]})


def problem_files(name: str) -> dict[str, str]:
    """Text of each file of the package, by its path, with `/`, in the package's folder.

    Raises
    ------
    ValueError
        If `name` is none that a problem, its distribution and its module can have.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    module = _checked(name)
    templates = Environment(
        loader=PackageLoader("mgeo.cli"), undefined=StrictUndefined, keep_trailing_newline=True
    )
    values = {
        "name": name,
        "module": module,
        "cls": "".join(word.capitalize() for word in re.split("[-_]", name)),
        "mgeo": _requirement(version("mgeo")),
    }
    return {
        path.format(module=module): templates.get_template(f"problem/{file}.j2").render(values)
        for path, file in _FILES.items()
    }


def write_problem(name: str, folder: Path | str | None = None) -> list[Path]:
    """Write the package into a new folder, by default `name` in the current one; its files.

    It is written whole or not at all.

    Raises
    ------
    ValueError
        If the name cannot be had, or is taken by what is installed.
    FileExistsError
        If there is a file or folder of this name.
    OSError
        If it cannot be written.
    """
    texts = problem_files(name)
    _check_free(name)
    folder = Path(name if folder is None else folder)
    if folder.exists() or folder.is_symlink():
        raise FileExistsError(f"{folder} exists: expected the name of a folder that is not there")
    if not folder.parent.is_dir():
        raise FileNotFoundError(f"there is no folder {folder.parent}")
    begun = folder.with_name(f".{folder.name}.{secrets.token_hex(8)}.tmp")
    try:
        for path, text in texts.items():
            file = begun / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8", newline="\n")
        os.rename(begun, folder)
    except BaseException:
        shutil.rmtree(begun, ignore_errors=True)
        raise
    return [folder / path for path in texts]


def _checked(name: str) -> str:
    """The module of a problem of this name."""
    module = name.replace("-", "_")
    if not _NAME.fullmatch(name) or keyword.iskeyword(module):
        raise ValueError(
            f"name = {name!r:.80}: expected lower-case words of letters and digits, joined by "
            "hyphens, such as my-beam, and none of Python's own"
        )
    return module


def _check_free(name: str) -> None:
    taken = [*installed_plugins(PROBLEMS), *installed_plugins(COMMANDS)]
    for plugin in taken:
        if plugin.name == name:
            raise ValueError(
                f"name = {name!r}: taken by {plugin.distribution} {plugin.version}; expected "
                "another one"
            )
    if importlib.util.find_spec(_checked(name)) is not None:
        raise ValueError(
            f"name = {name!r}: a module {_checked(name)} is installed; expected another name"
        )


def _requirement(of: str) -> str:
    """This version or a later one that keeps its promises: up to the next minor one."""
    major, minor = map(int, of.split(".")[:2])
    return f"mgeo>={of},<{major}.{minor + 1}"
