"""``mgeo attitude export``: files from which the plan is read back."""

import json
import math

import brahe.ccsds
import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.plan import ManeuverPlan, read_json, to_csv, to_uplink_csv, write_plan


def test_export_in_several_formats(run, folder, front, tmp_path):
    paths = [tmp_path / f"plan{suffix}" for suffix in (".json", ".csv", ".aem", ".uplink.csv")]
    flags = ("--pick", "min-trace", "--originator", "INPE", "--aem-version", "2.0")
    done = run("export", folder, *paths, *flags)
    plan = front.select_plan("min-trace")
    rows = {line.split("  ")[0]: line for line in done.stdout.splitlines()}
    assert rows.keys() >= {str(path) for path in paths}
    n_epochs = 1 + sum(math.ceil(phase.duration) for phase in plan.phases)
    assert f"{n_epochs:,} epochs" in rows[str(paths[2])]
    assert read_json(paths[0]) == plan
    assert paths[1].read_text(encoding="utf-8") == to_csv(plan)
    message = brahe.ccsds.AEM.from_file(str(paths[2]))
    assert message.originator == "INPE"
    assert len(message.segments) == len(plan.phases)
    assert paths[3].read_text(encoding="utf-8") == to_uplink_csv(plan)
    assert sorted(tmp_path.iterdir()) == sorted(paths)


def test_existing_files_are_not_replaced_without_overwrite(run, folder, tmp_path):
    path = tmp_path / "plan.csv"
    path.write_text("precious")
    done = run("export", folder, tmp_path / "plan.json", path, code=2)
    assert "plan.csv exists: choose another name or allow --overwrite" in done.stderr
    assert list(tmp_path.iterdir()) == [path]  # The other file is not written either.
    assert path.read_text() == "precious"
    run("export", folder, path, "--overwrite")
    assert path.read_text().startswith("row,phase,")


def test_violating_plan_is_rejected_without_force(run, violating, tmp_path):
    paths = [tmp_path / f"plan{suffix}" for suffix in (".json", ".csv", ".aem")]
    done = run("export", violating, *paths, code=2)
    violation = (
        "wheel momentum 0.00174533 N m s, at most 0.000174533 N m s, violated by 0.00157 N m s"
    )
    assert done.stderr == (
        f"Error: the plan violates 1 of its scenario's constraints ({violation}): choose another "
        "plan or allow --force\n"
    )
    assert list(tmp_path.iterdir()) == []
    run("export", violating, *paths, "--force")
    assert read_json(paths[0]) == read_json(violating)
    assert f"# VIOLATED CONSTRAINT: {violation}\nrow," in paths[1].read_text(encoding="utf-8")
    assert f"\nCOMMENT VIOLATED CONSTRAINT: {violation}\n" in paths[2].read_text(encoding="utf-8")


@pytest.mark.parametrize("slew_back", [False, True])
def test_final_rate_is_reported_unless_the_plan_slews_back(run, tmp_path, slew_back):
    maneuvers = {"slew_back": slew_back, "max_acceleration_deg_s2": 0.1}
    table = {"preset": "cubesat_6u", "duration": 600.0, "maneuvers": maneuvers}
    design = (*(0.0, 0.0, 0.0, 60.0) * 5, 0.3, 0.0, 0.4, 0.0)  # The plan ends with a ramp.
    plan = ManeuverPlan(Scenario.from_dict(table), design)
    write_plan(plan, tmp_path / "plan.json")
    done = run("export", tmp_path / "plan.json", tmp_path / "plan.csv", "--json")
    found = [line for line in json.loads(done.stdout)["warnings"] if "slew_back" in line]
    assert len(found) == (0 if slew_back else 1)
    assert slew_back or "0.50 deg/s" in found[0]


def test_files_are_listed_in_json(run, folder, tmp_path):
    path = tmp_path / "plan.json"
    assert json.loads(run("export", folder, path, "--json").stdout)["files"] == [str(path)]


@pytest.mark.cases(2)
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("plan.txt",), "plan.txt: expected a name that ends in .json, .uplink.csv, .csv, .aem"),
        (("none/a.csv",), "there is no folder none"),
        (("a.aem", "--originator", "Mixed"), "originator = 'Mixed'"),
    ],
)
def test_invalid_arguments_are_rejected(run, folder, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.csv").mkdir()
    done = run("export", folder, *arguments, code=2)
    assert message in done.stderr
    assert done.stderr.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["folder.csv"]
