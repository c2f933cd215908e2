"""`mgeo attitude check`: the compiled filter of one's own scenario beside filterpy."""

import json

from mgeo_attitude import Scenario
from mgeo_attitude.commands import compare_filters


def scenario_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('preset = "paper"\nduration = 900.0\n[convergence]\nwindow = 60.0\n')
    return path


def test_the_filters_agree(run, tmp_path):
    done = run("check", scenario_file(tmp_path), "--plans", 2, "--json")
    found = json.loads(done.stdout)
    assert found["same_end"]
    assert 0.0 < found["difference"] < 1e-9
    assert found["designs"] == 2


def test_filters_that_differ_end_with_code_3(run, tmp_path, monkeypatch):
    monkeypatch.setattr("mgeo_attitude.commands.check.TOLERANCE", 0.0)
    done = run("check", scenario_file(tmp_path), "--plans", 1, code=3)
    assert "1 random plans" in done.stdout
    assert "0 allowed" in done.stdout


def test_the_same_seed_checks_the_same_plans():
    scenario = Scenario.from_dict(
        {"preset": "paper", "duration": 600.0, "convergence": {"window": 60.0}}
    )
    first, second = (compare_filters(scenario, 2, seed) for seed in (7, 7))
    assert first == second
