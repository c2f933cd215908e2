"""A plugin may import mgeo, and mgeo never imports a plugin."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.imports import packages

ROOT = Path(__file__).parents[1]
MGEO = ROOT / "mgeo"
ATTITUDE = ROOT / "problems" / "attitude" / "mgeo_attitude"
CALIBRATION = ROOT / "problems" / "calibration" / "mgeo_calibration"


def test_mgeo_imports_no_plugin():
    found = packages(*MGEO.rglob("*.py"))
    assert {"pymoo", "numpy"} <= found  # the search finds what is there
    assert not {name for name in found if name.startswith("mgeo_")}


def test_a_plugin_does_without_one_that_builds_on_it():
    found = packages(*ATTITUDE.rglob("*.py"))
    assert "mgeo" in found
    assert "mgeo_suite" not in found


@pytest.mark.slow
def test_planning_does_without_calibration():
    """But for names that were here before, which are looked up where they are now."""
    named = {path.name for path in ATTITUDE.rglob("*.py") if "mgeo_calibration" in packages(path)}
    assert named == set()
    assert "mgeo_attitude" in packages(*CALIBRATION.rglob("*.py"))
    code = """
from mgeo_attitude.plan import ManeuverPlan
from mgeo_attitude.commands.app import app
from mgeo_attitude import AttitudeManeuverProblem, Scenario

plan = ManeuverPlan(Scenario.paper(), (0.5, 0.2, 0.1, 300.0) * 3)
plan.answer, plan.timeline(), plan.compare()
"""
    assert loaded(code, "mgeo_calibration") == "[]"


def loaded(code, *packages):
    """Modules of packages that are loaded once the code has been run."""
    lookup = f"[m for m in sys.modules if m.partition('.')[0] in {packages!r}]"
    done = subprocess.run(
        [sys.executable, "-c", f"import sys\n{code}\nprint({lookup})"],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_all_of_mgeo_is_loaded_without_a_plugin():
    code = "import mgeo\nfor name in mgeo.__all__: getattr(mgeo, name)"
    assert loaded(code, "mgeo_attitude") == "[]"


@pytest.mark.slow
def test_the_problem_is_solved_by_pymoo_without_commands_and_figures():
    code = """
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.optimize import minimize

problem = AttitudeManeuverProblem()
result = minimize(problem, NSGA2(pop_size=8), ("n_eval", 16), seed=1)
assert result.F.shape[1] == 2
"""
    assert loaded(code, "typer", "plotly") == "[]"


def test_names_that_are_of_calibration_now_are_still_found_and_say_so():
    import mgeo_attitude
    import mgeo_calibration

    for name in mgeo_attitude._MOVED:
        with pytest.warns(DeprecationWarning, match=f"is mgeo_calibration.{name} now"):
            assert getattr(mgeo_attitude, name) is getattr(mgeo_calibration, name)


def test_what_nobody_has_asked_for_is_not_loaded():
    code = """
from mgeo_attitude import AttitudeManeuverProblem, Scenario

room, file = "mgeo_attitude.bound", "mgeo_attitude.environment.ephemeris_file"
assert not {"pydantic", "mgeo.algorithms", room, file} & {*sys.modules}
from mgeo_calibration import calibrate

rooms = {f"mgeo_calibration.{room}" for room in ("flight", "simulation", "commands")}
assert not {"mgeo.algorithms", file, *rooms} & {*sys.modules}
import mgeo_calibration.commands.calibrate

assert not {"mgeo.runs", "mgeo_attitude.bound", "plotly", "scipy.stats", file} & {*sys.modules}
import mgeo.report.static

assert not {"mgeo.algorithms", "mgeo.studies"} & {*sys.modules}
"""
    assert loaded(f"{code}AttitudeManeuverProblem, Scenario, calibrate", "mgeo_suite") == "[]"
