"""The code, commands and scenario files of the pages on the attitude problem."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.sensors import Gyro
from mgeo_calibration import TelemetryMapping

from .pages import DOCS, blocks, run, saved_files


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
        *(text for text in blocks("how-to/robust-plans.md", "toml")),
        *(
            text
            for page in ("how-to/describe-your-satellite.md", "how-to/describe-sensors.md")
            for name, text in saved_files(page).items()
            # catalog.toml needs another file, typo.toml is wrong, star.toml needs a sensor class.
            if name.endswith(".toml") and name not in ("catalog.toml", "typo.toml", "star.toml")
        ),
    ],
    ids=lambda text: getattr(text, "stem", None),
)
def test_scenarios_are_read(text):
    assert Scenario.from_toml(text).sensors


@pytest.mark.slow
@pytest.mark.parametrize("start", ["nadir", "sun"])
def test_stored_fronts_belong_to_their_scenarios(start):
    table = np.loadtxt(DOCS / "fronts" / f"{start}.csv", delimiter=",", skiprows=1)
    problem = AttitudeManeuverProblem(Scenario.from_toml(DOCS / "scenarios" / f"{start}.toml"))
    X, F = table[:3, : problem.n_var], table[:3, problem.n_var : problem.n_var + 2]
    np.testing.assert_allclose(problem.evaluate(X, return_values_of=["F"]), F, rtol=1e-9)


@pytest.mark.parametrize("page", ["read-telemetry", "calibrate-from-telemetry"])
def test_mapping_files_are_read(page, tmp_path):
    page = f"how-to/{page}.md"
    texts = [*saved_files(page).values(), *blocks(page, "toml")]
    for text in texts:
        (tmp_path / "columns.toml").write_text(text)
        TelemetryMapping.from_toml(tmp_path / "columns.toml")
    assert texts


@pytest.mark.slow
@pytest.mark.parametrize(("name", "evaluations"), [("cubesat-1u", 60), ("limits", 240)])
def test_searches_with_actuators_have_ramps(name, evaluations, folder):
    options = f"--evaluations {evaluations} --out runs/{name} --quiet"
    run(f"mgeo solve attitude --scenario docs/scenarios/{name}.toml {options}")
    run(f"mgeo report runs/{name}")
    assert "ramp to maneuver 1" in run(
        f"mgeo attitude show runs/{name} --pick min-trace --section attitudes"
    )


@pytest.mark.slow
def test_infeasible_scenarios(folder):
    """Every command shows the nearest plans, or why there is none."""
    files = saved_files("how-to/describe-your-satellite.md")
    for name in ("beyond.toml", "tight.toml"):
        Path(name).write_text(files[name])
    printed = run("mgeo solve attitude --scenario beyond.toml --out runs/beyond", codes=(3,))
    assert "sun misalignment" in printed
    solve = "mgeo solve attitude --scenario tight.toml --evaluations 960 --out runs/tight"
    assert re.search(r"Relax (wheel momentum|1-sigma of attitude)", run(solve, codes=(3,)))
    assert Path("runs/tight/nearest.csv").is_file()
    run("mgeo attitude show runs/tight --solution 0")
    run("mgeo report runs/tight")


@pytest.mark.parametrize(
    "path", sorted((DOCS / "explanation").glob("*.md")), ids=lambda path: path.stem
)
def test_equation_labels_end_in_the_number_of_the_equation(path):
    """Equations are numbered within a page, so that the label shows the number in the source."""
    labels = re.findall(r"^\$\$ \((.*)\)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    assert [int(label.rpartition("-")[2]) for label in labels] == [*range(1, len(labels) + 1)]


def test_rate_random_walk_from_a_bias_stability():
    """The least Allan deviation of simulated noise is the stability in the tutorial's formula."""
    page = (DOCS / "tutorials/attitude-control.md").read_text(encoding="utf-8")
    (factor,) = re.findall(r"`rate_random_walk` \| (\S+) · B² / N, with B in", page)
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
