"""What docs/command-line.md shows works as it stands there."""

import json
import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app

from .attitude.conftest import few_flights  # noqa: F401

PAGE = (Path(__file__).parents[1] / "docs" / "command-line.md").read_text(encoding="utf-8")
STUDY = """
title = "Two algorithms"
evaluations = 300
seeds = 4
[[problems]]
name = "pymoo:zdt1"
[[algorithms]]
name = ["mgeo-real", "nsga2"]
"""


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


def keys(command):
    """What the table of documents names in the row of a command."""
    (row,) = re.findall(rf"^\| .*`{command}`[^|]*\| (.*) \|$", PAGE, re.MULTILINE)
    return set(re.findall(r"`(\w+)`", row))


def all_keys(value):
    if isinstance(value, list):
        return set().union(*map(all_keys, value))
    return set(value).union(*map(all_keys, value.values())) if isinstance(value, dict) else set()


def invoke(line, expected=0):
    # a few generations will do here
    arguments, _, file = line.replace("1080 --out", "480 --out").partition(" > ")
    program, *words = shlex.split(arguments)
    assert program == "mgeo"
    done = CliRunner().invoke(app, words, prog_name="mgeo")
    assert done.exit_code == expected, done.output
    if file:
        Path(file).write_text(done.stdout)
    return done.stdout


@pytest.mark.slow
def test_the_commands_do_what_the_page_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("study.toml").write_text(STUDY)
    printed = {line: invoke(line) for block in blocks("sh") for line in block.splitlines()}
    assert (
        "12 variables, 2 objectives" in printed["mgeo solve attitude --evaluations 1080 --dry-run"]
    )
    assert Path("runs/first/report.html").stat().st_size > 1_000_000
    result = json.loads(Path("result.json").read_text())
    assert set(result) | set(result["answer"]) == keys("solve")
    studied = json.loads(Path("study.json").read_text())
    assert keys("study") <= all_keys(studied)
    assert set(studied) <= keys("study")
    for line, command in (
        ("mgeo solve attitude --evaluations 1080 --dry-run --json", "solve --dry-run"),
        ("mgeo study study.toml --dry-run --json --seeds 1", "study --dry-run"),
        ("mgeo report runs/script --json", "report"),
    ):
        assert set(json.loads(invoke(line))) == keys(command)
    listed = json.loads(invoke("mgeo problems --json"))
    assert set(listed) | set(listed["problems"][0]) == keys("problems")
    assert invoke("mgeo solve attitude --json --scenario nothing", expected=2) == ""
