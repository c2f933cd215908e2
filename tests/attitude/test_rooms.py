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
    "maneuvers": {"fields", "scenario"},
    "filter": {"scenario", "sensors", "environment", "maneuvers"},
}


def imported(path: Path) -> set[str]:
    """What a file imports of the package, modules or names in them, dotted within it."""
    here, found = ("mgeo_attitude", *path.relative_to(PACKAGE).parts), set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            start = here[: len(here) - node.level] if node.level else ()
            module = (*start, *(node.module or "").split("."))
            names = [".".join((*module, alias.name)) for alias in node.names]
            found |= {name for each in names for name in (each, each.rpartition(".")[0])}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return {name.removeprefix("mgeo_attitude.") for name in found if name[:14] == "mgeo_attitude."}


@pytest.mark.parametrize("room", BELOW)
def test_a_room_imports_only_those_below(room: str) -> None:
    others = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").is_file()}
    names = set().union(*map(imported, (PACKAGE / room).glob("*.py")))
    found = {name.partition(".")[0] for name in names}
    assert found & others - {room} <= BELOW[room]
    single = {path.stem for path in PACKAGE.glob("*.py")}
    assert found & single <= {"_typing", "constants", "files", "rotation", "units", "vector"}


def test_modules_form_no_circle() -> None:
    paths = {
        ".".join(path.relative_to(PACKAGE).with_suffix("").parts).removesuffix(".__init__"): path
        for path in PACKAGE.rglob("*.py")
        if path.parent.name != "filter"
    }
    below = {name: imported(path) & paths.keys() - {name} for name, path in paths.items()}
    while below:
        free = [name for name, uses in below.items() if not uses & below.keys()]
        assert free, f"a circle among {sorted(below)}"
        for name in free:
            del below[name]
