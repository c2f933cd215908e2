"""What commands print where 80 columns are asked for: nothing is wider, nothing cut."""

import os

import pytest
import typer
from typer.testing import CliRunner

from mgeo.cli.app import app

STUDY = """
title = "Two algorithms on two functions"
evaluations = 600
seeds = 3

[[problems]]
name = "pymoo:zdt1"

[[algorithms]]
name = "mgeo-directed"

[[algorithms]]
name = "mgeo-real"
"""
HELP = typer.main.get_command(app)


def commands_of(group, words=()):
    """The words of a command and of all commands within it."""
    yield words
    with group.make_context(words[-1] if words else "mgeo", [], resilient_parsing=True) as context:
        names = group.list_commands(context) if hasattr(group, "list_commands") else []
        for name in names:
            _, found, _ = group.resolve_command(context, [name])
            yield from commands_of(found, (*words, name))


@pytest.fixture
def printed(monkeypatch, tmp_path):
    """Runs a command at 80 columns; everything it says, of which nothing may be wider."""
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.chdir(tmp_path)

    def invoke(*words, code=0):
        done = CliRunner().invoke(app, [str(word) for word in words], prog_name="mgeo")
        text = done.stdout + done.stderr
        assert done.exit_code == code, text
        assert text.strip()
        for line in text.splitlines():
            # a path is not broken, nor is an example
            assert len(line) <= 80 or os.sep in line or line.startswith("    mgeo"), line
        return text

    return invoke


def test_help(printed):
    every = list(commands_of(HELP))
    assert ("attitude", "verify") in every
    assert ("suite", "catalog") in every
    for words in every:
        printed(*words, "--help")


@pytest.mark.parametrize(
    "words",
    [
        ["problems"],
        ["algorithms"],
        ["algorithms", "mgeo-directed"],
        ["suite", "catalog"],
        ["solve", "pymoo:zdt1", "--evaluations", 900],
        ["solve", "pymoo:zdt1", "--evaluations", 900, "--verbose"],
        ["solve", "pymoo:zdt1", "--dry-run"],
    ],
)
def test_lists_and_runs(printed, words):
    printed(*words)


def test_errors(printed):
    printed("solve", "atitude", code=2)
    printed("solve", "pymoo:zdt1", "--algorithm", "mgeo-read", code=2)


@pytest.mark.slow
def test_a_study(printed, tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    printed("study", "study.toml", "--dry-run")
    text = printed("study", "study.toml", "--jobs", 1)
    assert "hypervolume" in text
    assert "IGD+" in text


@pytest.mark.cases(0)
@pytest.mark.parametrize("words", [["show"], ["verify", "--runs", 10]])
def test_plans(printed, words, folder):
    name, *rest = words
    text = printed("attitude", name, folder, *rest)
    if name == "show":
        assert "x, y, z in turn, there and back" in " ".join(text.split())


def test_a_run_that_goes_on(printed):
    printed("solve", "pymoo:zdt1", "--evaluations", 300, "--out", "run")
    printed("resume", "run", "--evaluations", 600)
    printed("report", "run")


@pytest.mark.slow
def test_from_a_plan_to_a_calibration(printed, folder):
    printed("attitude", "export", folder, "plan.json", "plan.uplink.csv", "plan.aem")
    printed("attitude", "fly", "plan.json", "--out", "flown.csv", "--truth", "truth.json")
    printed("attitude", "calibrate", "flown.csv", "--plan", "plan.json", "--out", "calibration")
    printed("attitude", "check", "paper", "--plans", 1)
    printed("report", "plan.json", "plan.json", "--out", "compared.html")


def test_the_first_line_is_what_is_done(printed):
    text = printed("solve", "pymoo:zdt1", "--evaluations", 100, "--tau", 2.5)
    told = "pymoo:zdt1 · mgeo-directed (tau = 2.5) · seed 1: 100 evaluations of 30 variables for f1"
    assert told in " ".join(text.split())
