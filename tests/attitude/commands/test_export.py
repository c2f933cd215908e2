"""``mgeo attitude export``: files that read back as the plan."""

import brahe.ccsds
import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.export_formats import FORMATS
from mgeo_attitude.plan import read_json, to_csv, to_uplink_csv

from mgeo.store.run_folder import write_run

from ..small_run import small_run


def test_all_formats(run, folder, front, tmp_path):
    paths = [tmp_path / f"plan{suffix}" for suffix in (".json", ".csv", ".aem", ".uplink.csv")]
    flags = ("--pick", "best", "--originator", "INPE", "--aem-version", "2.0")
    done = run("export", folder, *paths, *flags)
    assert done.stdout.splitlines() == [f"wrote {path}" for path in paths]
    plan = front.plan("best")
    assert read_json(paths[0]) == plan
    assert paths[1].read_text(encoding="utf-8") == to_csv(plan)
    message = brahe.ccsds.AEM.from_file(str(paths[2]))
    assert message.originator == "INPE"
    assert len(message.segments) == len(plan.phases)
    assert paths[3].read_text(encoding="utf-8") == to_uplink_csv(plan)
    assert sorted(tmp_path.iterdir()) == sorted(paths)


def test_help_lists_every_format(run):
    text = run("export", "--help").stdout
    assert all(each.suffix in text for each in FORMATS)


def test_from_a_plan_and_with_the_names_of_a_satellite(run, folder, tmp_path):
    assert run("export", folder, tmp_path / "plan.json", "-q").stdout == ""
    run(
        *("export", tmp_path / "plan.json", tmp_path / "one.aem"),
        *("--object-name", "SAT", "--object-id", "2021-015A", "--spacing", "10"),
    )
    text = (tmp_path / "one.aem").read_text(encoding="utf-8")
    assert text.startswith("CCSDS_AEM_VERS = 1.0\n")
    assert "OBJECT_NAME = SAT\nOBJECT_ID = 2021-015A\n" in text


def test_nothing_is_replaced_unless_allowed(run, folder, tmp_path):
    path = tmp_path / "plan.csv"
    path.write_text("precious")
    done = run("export", folder, tmp_path / "plan.json", path, code=2)
    assert "plan.csv exists: choose another name or allow --overwrite" in done.stderr
    assert list(tmp_path.iterdir()) == [path]  # not even the first
    assert path.read_text() == "precious"
    run("export", folder, path, "--overwrite")
    assert path.read_text().startswith("row,phase,")


@pytest.mark.slow
def test_of_a_run_another_plan_is_named_that_keeps_all_limits(run, tmp_path):
    """The front keeps its constraints, but not every plan of it the limits of the slew back."""
    limit = {"boresight": [0.0, 0.0, -1.0], "half_angle_deg": 30.0, "attitude_sigmas": 0.0}
    table = {"preset": "paper", "duration": 2400.0, "step": 4.0, "path_limits": [limit]}
    table |= {"initial": {"pointing": "nadir"}, "maneuvers": {"slew_back": True}}
    problem = AttitudeManeuverProblem(Scenario.from_dict(table))
    made = small_run(problem)
    write_run(tmp_path / "run", made)
    kept = np.array(
        [(each["margin"] >= 0.0).all() for each in problem.view(made.outcome.X).limits()]
    )
    number = int(np.argmin(kept))
    assert kept[number - 1]
    assert not kept[number]
    command = ("export", tmp_path / "run", tmp_path / "plan.json", "--solution")
    done = run(*command, number, code=2)
    assert f"choose another plan, such as --solution {number - 1}, or allow --force" in done.stderr
    run(*command, number - 1)


def test_a_plan_that_violates_a_constraint_is_refused_unless_forced(run, violating, tmp_path):
    paths = [tmp_path / f"plan{suffix}" for suffix in (".json", ".csv", ".aem")]
    done = run("export", violating, *paths, code=2)
    told = "wheel momentum 0.00174533 N m s, at most 0.000174533 N m s, violated by 0.00157 N m s"
    assert done.stderr == (
        f"Error: the plan violates 1 of its scenario's constraints ({told}): choose another plan "
        "or allow --force\n"
    )
    assert list(tmp_path.iterdir()) == []
    run("export", violating, *paths, "--force")
    assert read_json(paths[0]) == read_json(violating)
    assert f"# VIOLATED CONSTRAINT: {told}\nrow," in paths[1].read_text(encoding="utf-8")
    assert f"\nCOMMENT VIOLATED CONSTRAINT: {told}\n" in paths[2].read_text(encoding="utf-8")


@pytest.mark.cases(2)
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("plan.txt",), "plan.txt: expected a name that ends in .json, .uplink.csv, .csv, .aem"),
        (("a.csv", "a.csv"), "a.csv is named twice"),
        (("folder.csv",), "folder.csv is a folder"),
        (("none/a.csv",), "there is no folder none"),
        (("a.aem", "--aem-version", "3.0"), "version = '3.0'"),
        (("a.aem", "--spacing", "0"), "spacing = 0.0"),
        (("a.aem", "--originator", "Mixed"), "originator = 'Mixed'"),
    ],
)
def test_bad_arguments(run, folder, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.csv").mkdir()
    done = run("export", folder, *arguments, code=2)
    assert message in done.stderr
    assert done.stderr.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["folder.csv"]
