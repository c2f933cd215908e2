"""Rooms of mgeo import only what lies below them, and modules form no circle."""

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import mgeo

PACKAGE = Path(mgeo.__file__).parent
#: Rooms that each may import, also for type checks only and within functions.
BELOW = {
    "files": set(),
    "evaluation": set(),
    "benchmarks": set(),
    "plugins": {"benchmarks", "evaluation"},
    "persistence": {"algorithms", "evaluation", "files", "plugins"},
    "runs": {
        *("algorithms", "benchmarks", "evaluation", "files", "pareto", "persistence", "plugins")
    },
    "terminal": set(),
    "report": {"figures", "files", "pareto", "persistence", "plugins", "runs"},
}


def imported(path):
    """Modules of mgeo that a file imports, wherever the import stands."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield from (node.module, *(f"{node.module}.{alias.name}" for alias in node.names))


@pytest.mark.parametrize("room", BELOW)
def test_a_room_imports_only_those_below(room):
    names = {name for path in (PACKAGE / room).rglob("*.py") for name in imported(path)}
    rooms = {name.split(".")[1] for name in names if name.startswith("mgeo.")}
    others = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").is_file()}
    assert rooms & others - {room} <= BELOW[room]


@pytest.mark.parametrize("room", BELOW)
def test_modules_of_a_room_form_no_circle(room):
    paths = {f"mgeo.{room}.{path.stem}": path for path in (PACKAGE / room).glob("*.py")}
    graph = {name: paths.keys() & set(imported(path)) for name, path in paths.items()}
    TopologicalSorter(graph).prepare()  # or it raises a CycleError
