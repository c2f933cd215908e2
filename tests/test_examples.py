"""What CONTRIBUTING adds to the packages touches few files, and appears where it should."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
SECTIONS = re.findall(r"^### (.*?)\n(.*?)(?=^##)", TEXT + "\n##", re.DOTALL | re.MULTILINE)
PACKAGES = {
    "mgeo": "mgeo",
    "mgeo_attitude": "problems/attitude/mgeo_attitude",
    "mgeo_calibration": "problems/calibration/mgeo_calibration",
}

SCENARIO = """
preset = "paper"
duration = 2400.0
objectives = ["t_end", "trace", "attitude_variance"]
latest = 2350.0
orbit.propagator = "decaying"

[[sensors]]
kind = "sun-sensor"

[[sensors]]
kind = "ram-sensor"
name = "ram"
noise_rad = 0.02

[[path_limits]]
reference = "zenith"
boresight = [0.0, 0.0, 1.0]
half_angle_deg = 1.0
attitude_sigmas = 0.0
"""


def changes(section):
    """Path below the root, old text (None for a new file) and new text of each change."""
    for language, path, body in re.findall(
        r"```(python|diff)\n(?:#|\+\+\+) (\S+)\n(.*?)```", section, re.DOTALL
    ):
        for hunk in [body] if language == "python" else body.split("@@\n"):
            if language == "python":
                yield path, None, hunk
                continue
            lines = [(line[0], line[1:]) for line in hunk.splitlines()]
            old, new = ("\n".join(s for c, s in lines if c in kept) for kept in (" -", " +"))
            yield path, old, new


def test_the_ways_through_the_code_lead_to_files():
    files = re.findall(r"`(\S+\.py)`", TEXT.partition("## Where to begin")[2].partition("##")[0])
    assert len(files) > 20
    assert [file for file in files if not (ROOT / file).is_file()] == []


@pytest.mark.parametrize(("title", "section"), SECTIONS, ids=[title for title, _ in SECTIONS])
def test_each_touches_few_files_and_lines(title, section):
    found = list(changes(section))
    assert len({path for path, _, _ in found}) == (1 if "direction" in title else 2)
    (code,) = [new for _, old, new in found if old is None] or [""]
    assert len(code.splitlines()) <= 25
    for path, old, new in found:
        if old is None:
            assert not (ROOT / path).exists()
        else:
            assert (ROOT / path).read_text(encoding="utf-8").count(old) == 1, (path, old)
            assert len(new.splitlines()) <= 10


def test_all_seven_are_there():
    assert [title.split()[-1] for title, _ in SECTIONS] == [
        *("sensor", "propagator", "objective", "limit", "limits", "figure", "algorithm")
    ]


@pytest.fixture(scope="module")
def extended(tmp_path_factory):
    """A folder with copies of the packages, to which all sections have been added."""
    folder = tmp_path_factory.mktemp("extended")
    places = {f"{source}/": folder / name for name, source in PACKAGES.items()}
    for source, place in places.items():
        shutil.copytree(ROOT / source, place, ignore=shutil.ignore_patterns("__pycache__"))
    for _, section in SECTIONS:
        for path, old, new in changes(section):
            (source,) = [source for source in places if path.startswith(source)]
            target = places[source] / path.removeprefix(source)
            text = new if old is None else target.read_text(encoding="utf-8").replace(old, new)
            target.write_text(text, encoding="utf-8")
    (folder / "scenario.toml").write_text(SCENARIO, encoding="utf-8")
    return folder


def mgeo(folder, *commands):
    """What commands print, one after the other in a process that finds the packages there."""
    lines = (f"assert not app({line.split()}, standalone_mode=False)" for line in commands)
    code = "\n".join(["from mgeo.cli.app import app", *lines])
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(folder), "COLUMNS": "200", "NO_COLOR": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
def test_all_of_them_appear_in_a_run_and_its_report(extended):
    """With packages that are copies, and nothing else than the sections changed in them."""
    solve = "solve attitude --scenario scenario.toml --algorithm mgeo-wide --evaluations 720 -q"
    assert "mgeo-wide" in mgeo(extended, "algorithms", f"{solve} --out run", "report run")
    text = (extended / "run" / "run.json").read_text(encoding="utf-8")
    configuration = json.loads(text)["configuration"]
    assert configuration["algorithm"] == "mgeo-wide"
    assert configuration["options"]["orbit"]["propagator"] == "decaying"
    assert configuration["options"]["sensors"][1]["noise_rad"] == 0.02
    header, *rows = (extended / "run" / "front.csv").read_text(encoding="utf-8").splitlines()
    assert header.endswith("t_end [s],trace [-],sum of attitude variances [rad²]")
    assert rows
    assert max(float(row.split(",")[-3]) for row in rows) <= 2350.0
    html = (extended / "run" / "report.html").read_text(encoding="utf-8")
    for words in (
        "ram misalignment, 1-sigma",
        "time to converge",
        "zenith off payload",
        "Altitude [km]",
    ):
        assert words in html
