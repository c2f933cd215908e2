"""``mgeo attitude check``: comparison of the compiled filter with filterpy."""

import dataclasses
import json

from mgeo_attitude import compare_filters


def write_scenario(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('preset = "paper"\nduration = 900.0\n[convergence]\nwindow = 60.0\n')
    return path


def test_filters_agree(run, tmp_path):
    done = run("check", write_scenario(tmp_path), "--plans", 2, "--json")
    found = json.loads(done.stdout)
    assert found["agrees"]
    assert found["has_equal_ends"]
    assert 0.0 < found["max_difference"] < 1e-9
    assert found["n_designs"] == 2


def test_differing_filters_exit_with_code_3(run, tmp_path, monkeypatch):
    def report_difference(*arguments):
        return dataclasses.replace(compare_filters(*arguments), max_difference=2e-9)

    monkeypatch.setattr("mgeo_attitude.filter.reference.compare_filters", report_difference)
    done = run("check", write_scenario(tmp_path), "--plans", 1, code=3)
    assert "2e-09" in done.stdout
    assert "NOT" in done.stdout
