"""What the pages of docs/ show works as it stands there."""

import re
import shlex
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Environment, Scenario
from mgeo_attitude.environment.directions import DIRECTIONS
from mgeo_attitude.environment.orbit import ORBITS
from mgeo_attitude.plan import ManeuverPlan, write_plan
from mgeo_attitude.scenario import FlightErrors, InitialConditions, Prior
from mgeo_attitude.sensors import Gyro
from mgeo_attitude.settings.base import declared, schema_of
from mgeo_calibration import TelemetryMapping, fly
from mgeo_calibration.telemetry.mapping import UNITS
from typer.testing import CliRunner

from mgeo.cli.app import app

DOCS = Path(__file__).parents[2] / "docs"


def page(name):
    return (DOCS / name).read_text(encoding="utf-8")


def blocks(name, language):
    return re.findall(rf"```{language}\n(.*?)```", page(name), re.DOTALL)


def run(command, *more, codes=(0,)):
    program, *arguments = shlex.split(command)
    assert program == "mgeo"
    done = CliRunner().invoke(app, [*arguments, *more])
    assert done.exit_code in codes, command + done.output + done.stderr
    return done.output


def test_the_file_of_limits_is_read_and_keeps_what_the_page_says():
    path = DOCS / "scenarios" / "limits.toml"
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    problem = AttitudeManeuverProblem.from_options(table)
    assert problem.scenario == Scenario.from_toml(path)
    assert problem.constraint_names == ("wheel momentum", "Sun off camera", "required 1-sigma")
    for name in problem.constraint_names:
        assert f"`{name.replace('camera', 'NAME')}`" in page("limits.md")
    limits = problem.scenario
    assert limits.maneuvers.max_acceleration_deg_s2 == 0.05
    assert limits.wheels.max_torque == 1e-4
    assert dict(limits.required_sigma) == {"attitude_deg": 0.17, "gyro.bias_deg_h": 2.0}
    assert (limits.gyro, limits.sensors) == (
        Scenario.cubesat_6u().gyro,
        Scenario.cubesat_6u().sensors,
    )


def test_the_page_names_all_directions_of_path_limits():
    table = page("limits.md").partition("(path-limits)=")[2].partition("(star-tracker)=")[0]
    assert re.findall(r"^\| `(\w+)`.* \|.*\|.*\|$", table, re.M) == ["reference", *DIRECTIONS]


def test_the_scenario_of_errors_is_read_and_every_error_is_on_its_page():
    text, follows, angles = blocks("errors.md", "toml")
    assert [len(sensor.noise()) for sensor in Scenario.from_toml(angles).sensors] == [2, 2]
    assert "gyro.bias_per_temp" in Scenario.from_toml(follows).suite.blocks
    scenario = Scenario.from_toml(text)
    assert scenario.sensors[0].sample_interval == 2.0
    assert (scenario.world.albedo, scenario.world.considered) == (0.03, ("orbit_error",))
    for owner in Scenario.cubesat_6u_full().suite.owners.values():
        for state in owner.states():
            assert state in ("bias", "misalignment") or f".{state}`" in page("errors.md")


@pytest.mark.slow
def test_the_ways_to_an_orbit(tmp_path, monkeypatch):
    """The element set's file, a table of positions, and files that are missing."""
    monkeypatch.chdir(tmp_path)
    tle = Scenario.from_toml(DOCS / "scenarios" / "iss.toml")
    elements, ephemeris = blocks("orbit.md", "toml")
    with pytest.raises(ValueError, match=r"orbit\.file = 'orbits/iss\.oem': expected a file"):
        Scenario.from_dict(tomllib.loads(ephemeris))
    lines = tle.orbit
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
    apart = sampled.position - Environment.from_scenario(scenario).position
    assert np.linalg.norm(apart, axis=1).max() < 1e-3  # m


@pytest.mark.slow
def test_a_start_and_a_slew_back():
    """A plan of the page's file, of which the nadir front is."""
    scenario = Scenario.from_toml(DOCS / "scenarios" / "nadir.toml")
    problem = AttitudeManeuverProblem(scenario)
    assert np.degrees(problem.model.initial_rate[1]) == pytest.approx(-0.060, abs=0.001)
    x = 2 * [0.4, -0.7, 0.2, 150.0, -0.5, 0.1, 0.8, 150.0, 0.1, 0.6, -0.6, 150.0]
    plan = ManeuverPlan.from_design(problem, x)
    assert 0.0 < plan.duration - plan.t_end < 300.0
    assert plan.phases[-1].label == "slew back"
    rows = re.findall(r"^\| `(\w+)` .*?\|", page("start-and-end.md"), re.M)[1:]
    assert rows == schema_of(InitialConditions)["properties"]["pointing"]["enum"]
    for key in declared(InitialConditions):
        assert f"`{key}`" in page("start-and-end.md").replace("initial.attitude", "attitude")


@pytest.mark.slow
@pytest.mark.parametrize("start", ["nadir", "sun"])
def test_stored_fronts_are_of_their_scenarios(start):
    table = np.loadtxt(DOCS / "fronts" / f"{start}.csv", delimiter=",", skiprows=1)
    problem = AttitudeManeuverProblem(Scenario.from_toml(DOCS / "scenarios" / f"{start}.toml"))
    X, F = table[:3, : problem.n_var], table[:3, problem.n_var : problem.n_var + 2]
    np.testing.assert_allclose(problem.evaluate(X, return_values_of=["F"]), F, rtol=1e-9)


def test_every_propagator_is_on_the_page():
    rows = re.findall(r"^\| (`.*?) \|", page("orbit.md"), re.M)[1:]
    named = [name for row in rows for name in re.findall(r"`(.*?)`", row)]
    assert set(named) == set(ORBITS.classes)


def test_the_tables_of_flights_and_rules_are_read():
    flights, rule = (Scenario.from_toml(text) for text in blocks("robust.md", "toml"))
    assert flights.flight == FlightErrors(rate_error_deg_s=0.01, attitude_deg=5.0)
    assert (rule.convergence.rule, rule.convergence.factor) == ("settling", 1.25)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "start-research.md",
        "limits.md",
        "calibration.md",
        "consistency.md",
        "robust.md",
        "how-good.md",
    ],
)
def test_the_python_of_a_page(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(DOCS / "scenarios", "docs/scenarios")
    names = {"__name__": "page"}
    for code in blocks(name, "python"):
        exec(code, names)
    if name == "how-good.md":
        least = names["limit"](names["scenario"]).at(names["t_end"])
        assert ((names["trace"] / least)[names["t_end"] > 900.0] < 1.15).all()
    if name == "start-research.md":
        assert (tmp_path / "anytime.html").stat().st_size > 1000
        assert (names["measured"] < 1.0).all(axis=1).any()
    if name == "calibration.md":
        assert names["found"].supported
        assert set(names["found"].uplink()["mag"]) == {"dcm", "quaternion", "bias", "unit"}


def test_the_mapping_of_the_page_on_calibration(tmp_path):
    (text,) = blocks("calibration.md", "toml")
    (tmp_path / "columns.toml").write_text(text)
    mapping = TelemetryMapping.from_toml(tmp_path / "columns.toml")
    assert [entry.name for entry in mapping.sensors] == ["mag", "sun"]
    for unit, quantity in (("nT", mapping.sensors[0]), ("deg/s", mapping.gyro)):
        assert quantity.factor(unit) != 1.0
        for name in UNITS[unit]:
            assert re.search(rf"\b{re.escape(name)}\b", text)


@pytest.mark.slow
def test_the_command_of_the_page_on_calibration(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scenario = Scenario.from_toml('preset = "paper"\nduration = 900.0\n')
    scenario.save("mine.toml")
    plan = ManeuverPlan(scenario, (0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0, 0, 0, 1.0))
    write_plan(plan, "plan.json")
    fly(scenario, plan, 1).to_csv("telemetry.csv")
    command, _ = blocks("calibration.md", "sh")
    assert "the innovations support it" in run(command.strip())
    for path in Path("calibration").iterdir():
        assert f"`{path.name}`" in page("calibration.md")
    assert len(list(Path("calibration").iterdir())) == 4


def test_every_key_of_a_prior_is_on_the_page():
    for key in declared(Prior):
        assert f"| `{key}` |" in page("calibration.md")


@pytest.mark.slow
def test_which_satellite_leads_to_files_that_can_be_started_from(tmp_path, monkeypatch):
    text = page("which-satellite.md")
    rows = re.findall(r"^\| .*\]\((scenarios/[\w-]+\.toml)\) \| `(\w+)` \|$", text, re.MULTILINE)
    assert {preset for _, preset in rows} == {"cubesat_1u", "cubesat_6u", "microsatellite"}
    for file, preset in rows:
        table = tomllib.loads(page(file))
        assert table["preset"] == preset
        AttitudeManeuverProblem(Scenario.from_dict(table))
    monkeypatch.chdir(tmp_path)
    shutil.copytree(DOCS / "scenarios", "docs/scenarios")
    _, command = blocks("which-satellite.md", "sh")
    run(command.strip(), "--evaluations", "60", "--quiet")
    shown = run("mgeo attitude show runs/1u --pick best")
    assert "ramp to maneuver 1" in shown
    assert "assumed to be free" not in shown


@pytest.mark.campaign
@pytest.mark.slow
def test_what_comes_of_a_satellite_is_made_as_said(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(DOCS / "scenarios", "docs/scenarios")
    solve, verify, *others = blocks("which-satellite.md", "sh")[0].splitlines()
    run(solve, "--evaluations", "60", "--quiet", codes=(0, 3))
    run(verify, "--runs", "2", codes=(0, 3))
    for step in others:
        run(step, codes=(0, 3))
    assert Path("calibration/calibration.json").is_file()


@pytest.mark.cases(0, 1)
@pytest.mark.parametrize("objectives", [["t_end", "trace"], ["log_det", "angle", "t_end"]])
def test_the_command_with_limits(objectives, tmp_path, monkeypatch):
    """The page's file as it is, and with other objectives: every tool takes the run."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(DOCS / "scenarios", "docs/scenarios")
    file = Path("docs/scenarios/limits.toml")
    line = 'objectives = ["t_end", "trace"]'
    text = file.read_text(encoding="utf-8")
    assert line in text
    file.write_text(text.replace(line, f"objectives = {objectives}"), encoding="utf-8")
    command = blocks("limits.md", "sh")[0]
    run(command.strip(), "--evaluations", "240", "--quiet")
    assert Path("runs/limits/front.html").is_file()
    run("mgeo report runs/limits")
    assert "ramp to maneuver 1" in run("mgeo attitude show runs/limits --pick best")


@pytest.mark.slow
def test_the_way_out_of_no_plan(tmp_path, monkeypatch):
    """The page's scenario has no plan, and each command shows what comes nearest."""
    monkeypatch.chdir(tmp_path)
    scenario, beyond = blocks("limits.md", "toml")
    Path("beyond.toml").write_text(beyond)
    told = run("mgeo solve attitude --scenario beyond.toml --out runs/beyond", codes=(3,))
    assert " ".join(told.split()) in " ".join(blocks("limits.md", "text")[0].split())
    assert not Path("runs/beyond").exists()
    Path("tight.toml").write_text(scenario)
    solve, show, report = blocks("limits.md", "sh")[1].splitlines()
    told = run(solve, codes=(3,))
    assert "ways out" in told
    assert re.search(r"relax .*(wheel momentum|required 1-sigma)", told)
    assert Path("runs/tight/nearest.csv").is_file()
    assert "keeps all limits" in run(show)
    run(report)
    assert "Nothing that was found keeps all limits" in Path("runs/tight/report.html").read_text()


def test_the_bias_stability_of_a_data_sheet_becomes_the_least_allan_deviation():
    """Of a gyro's noise as the filter has it, drawn for eleven days, by the tutorial's formula."""
    (factor,) = re.findall(r"`rate_random_walk` \| (\S+) · B² / N, of B in", page("tutorial.md"))
    stability, walk = 2.0, 0.15  # °/h, °/√h
    gyro = Gyro(
        angle_random_walk_deg_per_sqrt_h=walk, rate_random_walk=float(factor) * stability**2 / walk
    )
    rng, n = np.random.default_rng(1), 1_000_000  # seconds
    white, drift = (np.sqrt(gyro.diffusion()[of][0]) for of in ("theta", "bias"))
    rate = white * rng.standard_normal(n) + np.cumsum(drift * rng.standard_normal(n))
    angle = np.concatenate([[0.0], np.cumsum(rate)])
    spans = np.unique(np.geomspace(20, 2000, 60).round().astype(int))
    allan = [
        np.sqrt(0.5 * (np.diff(angle[::span], n=2) ** 2).mean()) / span  # IEEE Std 952
        for span in spans
    ]
    assert 3600.0 * np.degrees(min(allan)) == pytest.approx(stability, rel=0.05)
    assert spans[0] < spans[np.argmin(allan)] < spans[-1]
