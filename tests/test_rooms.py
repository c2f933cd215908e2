"""Rooms, the folders of a package, import only those below them, and tests what they export."""

import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from tests.imports import entered, exported, graph, imported, modules, rooms

ROOT = Path(__file__).parents[1]
MGEO = ROOT / "mgeo"
ATTITUDE = ROOT / "problems" / "attitude" / "mgeo_attitude"
CALIBRATION = ROOT / "problems" / "calibration" / "mgeo_calibration"
SUITE = ROOT / "problems" / "suite" / "mgeo_suite"
PACKAGES = [MGEO, ATTITUDE, CALIBRATION, SUITE]

#: Rooms that each may import, also for type checks only and within functions.
OF_MGEO = {
    "validation": set(),
    "benchmarks": set(),
    "evaluation": {"validation"},
    "algorithms": {"evaluation", "validation"},
    "plugins": {"algorithms", "benchmarks", "evaluation", "figures", "validation"},
    "store": {"algorithms", "benchmarks", "evaluation", "plugins", "validation"},
    "runs": {"algorithms", "benchmarks", "evaluation", "plugins", "store", "validation"},
    "testing": {"algorithms", "evaluation", "figures", "plugins"},
    "report": {"algorithms", "evaluation", "figures", "plugins", "runs", "store", "validation"},
    "explore": {
        *("algorithms", "evaluation", "figures", "plugins", "report", "runs", "store"),
        "validation",
    },
}
OF_ATTITUDE = {
    "fields": set(),
    "geometry": set(),
    "environment": {"fields", "geometry"},
    "sensors": {"fields", "geometry", "environment"},
    "maneuvers": set(),
    "scenario": {"fields", "geometry", "environment", "maneuvers", "sensors"},
    "trajectory": {"fields", "maneuvers", "scenario"},
    "filter": {"fields", "geometry", "environment", "sensors", "scenario", "maneuvers"},
    "bound": {"geometry", "scenario", "sensors", "filter"},
    "refine": {"criteria", "filter", "maneuvers", "scenario"},
    "criteria": {
        *("environment", "fields", "filter", "geometry", "maneuvers", "scenario", "sensors")
    },
}
OF_CALIBRATION = {
    "telemetry": set(),
    "flight": {"telemetry"},
    "estimation": {"telemetry"},
    "calibration": {"estimation", "telemetry"},
    "simulation": {"calibration", "estimation", "flight", "telemetry"},
    "verification": {"flight", "simulation"},
}
#: What stands beside the rooms, and any of them may import.
SINGLE = {
    *("_compiled", "_foreign", "_typing", "terminal"),
    "files",
}


@pytest.mark.parametrize(
    ("package", "room", "below"),
    [
        pytest.param(package, room, below, id=f"{package.name}.{room}")
        for package, table in (
            (MGEO, OF_MGEO),
            (ATTITUDE, OF_ATTITUDE),
            (CALIBRATION, OF_CALIBRATION),
        )
        for room, below in table.items()
    ],
)
def test_a_room_imports_only_those_below(package, room, below):
    found = rooms(package, room)
    folders = {path.name for path in package.iterdir() if (path / "__init__.py").is_file()}
    assert found & folders <= below
    assert found - folders <= SINGLE


@pytest.mark.parametrize("package", PACKAGES, ids=lambda path: path.name)
def test_modules_form_no_circle(package):
    uses = graph(package)
    assert len(uses) > 8
    assert any(uses.values())
    TopologicalSorter(uses).prepare()  # or it raises a CycleError


@pytest.mark.parametrize("package", PACKAGES, ids=lambda path: path.name)
def test_tests_and_other_packages_import_what_rooms_export(package):
    """Their `__init__.pyi` shows in one place what others use of them."""
    found = {
        f"{path.relative_to(ROOT)}: {name}"
        for folder in {ROOT / "tests", *PACKAGES} - {package}
        for path in folder.rglob("*.py")
        for name in entered(imported(path, relative=folder.name == "tests"), package)
    }
    assert found == set()


@pytest.mark.parametrize("package", PACKAGES, ids=lambda path: path.name)
def test_what_is_called_as_a_module_is_of_that_module(package):
    """Only then `lazy_loader` keeps the module, once imported, from being found in its place."""
    for name in exported(package).keys() & modules(package).keys():
        home = exported(package)[name]
        assert name in (home, home.rpartition(".")[0]), name


@pytest.mark.campaign  # a name that a module has, too, is found by the test above and by mypy
@pytest.mark.slow
def test_rooms_export_what_they_say():
    """Whatever was imported before: a function is not hidden by a module of its name."""
    homes = {name: home for package in PACKAGES for name, home in exported(package).items()}
    assert len(homes) > 500
    code = f"""
from importlib import import_module
from types import ModuleType

for module in {[name for package in PACKAGES for name in modules(package)]}:
    module.endswith("__main__") or import_module(module)
for name, home in {homes}.items():
    room, _, short = name.rpartition(".")
    found = getattr(import_module(room), short)
    assert short in import_module(room).__all__, name
    if name == home:
        assert found is import_module(home), name
    else:
        assert found is getattr(import_module(home.rpartition(".")[0]), short), name
        assert not isinstance(found, ModuleType), name
"""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
