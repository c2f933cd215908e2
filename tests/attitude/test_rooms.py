"""Which rooms may import which: those below them, so that there is no circle."""

from __future__ import annotations

import ast
from pathlib import Path

import mgeo_attitude
import pytest

PACKAGE = Path(mgeo_attitude.__file__).parent
#: What each may import, also for type checks only and within functions.
BELOW = {
    "fields": set(),
    "sensors": {"fields", "environment"},
    "environment": {"fields"},
    "scenario": {"fields", "sensors", "environment"},
}


def imported(path: Path) -> set[str]:
    """Modules of the package that a file imports, by their dotted names within it."""
    here, found = ("mgeo_attitude", *path.relative_to(PACKAGE).parts), set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            start = here[: len(here) - node.level] if node.level else ()
            name = (*start, *(node.module or "").split("."))
            found |= {".".join(name[1:])} if name[0] == "mgeo_attitude" else set()
        elif isinstance(node, ast.Import):
            names = [alias.name.partition(".") for alias in node.names]
            found |= {rest for top, _, rest in names if top == "mgeo_attitude"}
    return found


@pytest.mark.parametrize("room", BELOW)
def test_a_room_imports_only_those_below(room: str) -> None:
    others = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").is_file()}
    names = set().union(*map(imported, (PACKAGE / room).glob("*.py")))
    found = {name.partition(".")[0] for name in names}
    assert found & others - {room} <= BELOW[room]
    assert found - others <= {"_typing", "constants", "files", "rotation", "units", "vector"}


@pytest.mark.parametrize("room", BELOW)
def test_modules_of_a_room_form_no_circle(room: str) -> None:
    paths = {f"{room}.{path.stem}": path for path in (PACKAGE / room).glob("*.py")}
    below = {name: imported(path) & paths.keys() for name, path in paths.items()}
    while below:
        free = [name for name, uses in below.items() if not uses & below.keys()]
        assert free, f"a circle among {sorted(below)}"
        for name in free:
            del below[name]
