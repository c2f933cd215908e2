"""Rooms, the folders of a package, import only those below them; no modules form a circle."""

from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from tests.imports import graph, rooms

ROOT = Path(__file__).parents[1]
MGEO = ROOT / "mgeo"
ATTITUDE = ROOT / "problems" / "attitude" / "mgeo_attitude"
CALIBRATION = ROOT / "problems" / "calibration" / "mgeo_calibration"
SUITE = ROOT / "problems" / "suite" / "mgeo_suite"

#: Rooms that each may import, also for type checks only and within functions.
OF_MGEO = {
    "validation": set(),
    "benchmarks": set(),
    "evaluation": {"validation"},
    "algorithms": {"evaluation", "validation"},
    "plugins": {"algorithms", "benchmarks", "evaluation", "figures", "validation"},
    "store": {"algorithms", "benchmarks", "evaluation", "plugins", "validation"},
    "runs": {"algorithms", "benchmarks", "evaluation", "plugins", "store", "validation"},
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
    "diagnosis": {"estimation", "telemetry"},
    "calibration": {"diagnosis", "estimation", "telemetry"},
    "simulation": {"calibration", "estimation", "flight", "telemetry"},
    "verification": {"flight", "simulation"},
}
#: What stands beside the rooms, and any of them may import.
SINGLE = {
    *("_foreign", "_typing", "terminal"),
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


@pytest.mark.parametrize(
    "package", [MGEO, ATTITUDE, CALIBRATION, SUITE], ids=lambda path: path.name
)
def test_modules_form_no_circle(package):
    uses = graph(package)
    assert len(uses) > 8
    assert any(uses.values())
    TopologicalSorter(uses).prepare()  # or it raises a CycleError
