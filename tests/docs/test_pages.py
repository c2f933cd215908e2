"""The code, commands and scenario files of the pages on the attitude problem."""

import re
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Environment, Scenario
from mgeo_attitude.plan import ManeuverPlan, write_plan
from mgeo_attitude.sensors import Gyro
from mgeo_calibration import TelemetryMapping, simulate_telemetry

from .pages import DOCS, blocks, run


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty current folder with the scenario files of the pages."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(DOCS / "scenarios", "docs/scenarios")
    return tmp_path


@pytest.mark.parametrize(
    "text",
    [
        *(path for path in (DOCS / "scenarios").glob("*.toml") if path.stem != "suite"),
        *(
            text
            for name in ("errors.md", "robust.md", "limits.md")
            for text in blocks(name, "toml")
        ),
    ],
    ids=lambda text: getattr(text, "stem", None),
)
def test_scenarios_are_read(text):
    assert Scenario.from_toml(text).sensors


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "start-research.md",
        "limits.md",
        "calibration.md",
        "telemetry.md",
        "consistency.md",
        "robust.md",
        "how-good.md",
        "start-and-end.md",
    ],
)
def test_python(name, folder):
    names = {"__name__": "page"}
    for code in blocks(name, "python"):
        exec(code, names)
    if name == "calibration.md":
        assert names["found"].is_consistent


@pytest.mark.slow
def test_orbits(tmp_path, monkeypatch):
    """An element set's file, and a table of positions."""
    monkeypatch.chdir(tmp_path)
    lines = Scenario.from_toml(DOCS / "scenarios" / "iss.toml").orbit
    elements, _ = blocks("orbit.md", "toml")
    Path("stations.omm").write_text(f"ISS (ZARYA)\n{lines.line1}\n{lines.line2}\n")
    found = Scenario.from_dict(tomllib.loads(elements)).orbit
    assert (found.line1, found.line2) == (lines.line1, lines.line2)
    scenario = Scenario.cubesat_6u()
    times = np.arange(-300.0, scenario.duration + 301.0, 60.0)
    rows = np.column_stack([times, scenario.orbit.propagate(scenario.epoch, times)[0]])
    np.savetxt("positions.csv", rows, "%.6f", ",", header="t_s,x_m,y_m,z_m", comments="")
    (code,) = blocks("orbit.md", "python")
    exec(code, {})
    sampled = Environment.from_scenario(Scenario.from_toml("scenario.toml"))
    difference = sampled.position - Environment.from_scenario(scenario).position
    assert np.linalg.norm(difference, axis=1).max() < 1e-3  # m


@pytest.mark.slow
@pytest.mark.parametrize("start", ["nadir", "sun"])
def test_stored_fronts_belong_to_their_scenarios(start):
    table = np.loadtxt(DOCS / "fronts" / f"{start}.csv", delimiter=",", skiprows=1)
    problem = AttitudeManeuverProblem(Scenario.from_toml(DOCS / "scenarios" / f"{start}.toml"))
    X, F = table[:3, : problem.n_var], table[:3, problem.n_var : problem.n_var + 2]
    np.testing.assert_allclose(problem.evaluate(X, return_values_of=["F"]), F, rtol=1e-9)


@pytest.mark.slow
def test_calibration(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (mapping,) = blocks("telemetry.md", "toml")
    Path("columns.toml").write_text(mapping)
    TelemetryMapping.from_toml("columns.toml")
    scenario = Scenario.from_toml('preset = "paper"\nduration = 900.0\n')
    scenario.save("mine.toml")
    plan = ManeuverPlan(scenario, (0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0, 0, 0, 1.0))
    write_plan(plan, "plan.json")
    simulate_telemetry(scenario, plan, 1).to_csv("telemetry.csv")
    run(blocks("calibration.md", "sh")[0].strip())
    files = {"calibration.json", "calibration.csv", "attitude.csv", "calibration.html"}
    assert {path.name for path in Path("calibration").iterdir()} == files


@pytest.mark.slow
def test_which_satellite(folder):
    _, coils = blocks("which-satellite.md", "sh")
    run(coils.strip(), "--evaluations", "60", "--quiet")
    assert "ramp to maneuver 1" in run(
        "mgeo attitude show runs/1u --pick min-trace --section phases"
    )


@pytest.mark.slow
def test_limits(folder):
    run(blocks("limits.md", "sh")[0].strip(), "--evaluations", "240", "--quiet")
    run("mgeo report runs/limits")
    assert "ramp to maneuver 1" in run(
        "mgeo attitude show runs/limits --pick min-trace --section phases"
    )


@pytest.mark.slow
def test_no_plan_within_the_limits(folder):
    """Every command shows the nearest plans, or why there is none."""
    scenario, impossible = blocks("limits.md", "toml")
    Path("beyond.toml").write_text(impossible)
    printed = run("mgeo solve attitude --scenario beyond.toml --out runs/beyond", codes=(3,))
    assert " ".join(printed.split()) in " ".join(blocks("limits.md", "text")[0].split())
    Path("tight.toml").write_text(scenario)
    solve, show, report = blocks("limits.md", "sh")[1].splitlines()
    assert re.search(r"relax .*(wheel momentum|required 1-sigma)", run(solve, codes=(3,)))
    assert Path("runs/tight/nearest.csv").is_file()
    run(show)
    run(report)


def test_rate_random_walk_from_a_bias_stability():
    """The least Allan deviation of simulated noise is the stability in the tutorial's formula."""
    page = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    (factor,) = re.findall(r"`rate_random_walk` \| (\S+) · B² / N, of B in", page)
    stability, walk = 2.0, 0.15  # °/h, °/√h
    gyro = Gyro(
        angle_random_walk_deg_per_sqrt_h=walk, rate_random_walk=float(factor) * stability**2 / walk
    )
    rng, n = np.random.default_rng(1), 1_000_000  # seconds
    white, drift = (np.sqrt(gyro.compute_noise_density()[of][0]) for of in ("theta", "bias"))
    rate = white * rng.standard_normal(n) + np.cumsum(drift * rng.standard_normal(n))
    angle = np.concatenate([[0.0], np.cumsum(rate)])
    spans = np.unique(np.geomspace(20, 2000, 60).round().astype(int))
    allan = [
        np.sqrt(0.5 * (np.diff(angle[::span], n=2) ** 2).mean()) / span  # IEEE Std 952
        for span in spans
    ]
    assert 3600.0 * np.degrees(min(allan)) == pytest.approx(stability, rel=0.05)
    assert spans[0] < spans[np.argmin(allan)] < spans[-1]
