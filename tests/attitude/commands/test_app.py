"""The commands as part of ``mgeo``, as a process, and their help."""

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import mgeo_attitude.commands.app as planning
import mgeo_calibration.commands.app as calibration
import pytest
import typer

from tests.mgeo.cli.test_completion import offered

ROOT = Path(__file__).parents[3]
EXAMPLES = {**planning.EXAMPLES, **calibration.EXAMPLES}
GROUP = typer.main.get_command(planning.app)
GROUP.commands |= typer.main.get_command(calibration.app).commands


@pytest.mark.slow
def test_process(tmp_path):
    """As installed: one line on stderr and exit code 2, without importing what is not needed."""
    done = subprocess.run(
        [sys.executable, "-m", "mgeo", "attitude", "show", str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=120,
        env=dict(os.environ),  # without the COLUMNS that readline, which pytest loads, has set in C
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr == f"Error: {tmp_path} holds no run: there is no run.json\n"


def test_help_names_the_commands(run):
    text = run("--help").stdout
    for command in ("show", "verify", "export", "calibrate"):
        assert command in text
    assert run(code=2).stderr == text  # without words, too


def test_tracebacks_on_demand(run, tmp_path):
    done = run("show", tmp_path, "--debug", code=2)
    assert "Traceback (most recent call last)" in done.stderr
    assert done.stderr.splitlines()[-1].startswith("Error: ")


def test_a_bug_is_one_line_with_another_exit_code(run, folder, monkeypatch):
    def fail(*arguments):
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("mgeo_attitude.commands.show.print_plan", fail)
    done = run("show", folder, code=1)
    assert re.fullmatch(
        r"Error: ZeroDivisionError: division by zero \(test_app.py, line \d+; see --debug\)\n",
        done.stderr,
    )


@pytest.mark.parametrize("command", GROUP.commands)
def test_every_command_has_examples_that_can_be_typed(run, command):
    shown = " ".join(run(command, "--help").stdout.replace(" \\\n", "\n").split())
    for example in EXAMPLES[command]:
        assert example in shown  # as a shell reads it
        program, group, name, *arguments = shlex.split(re.split("[|>]", example)[0])
        assert (program, group, name) == ("mgeo", "attitude", command)
        with GROUP.commands[command].make_context(command, arguments):
            pass


@pytest.mark.parametrize("arguments", [["--nonsense"], ["sho"], ["show"], ["show", "a", "--nope"]])
def test_usage_errors_are_one_line(run, arguments):
    done = run(*arguments, code=2)
    assert re.fullmatch(r"Error: .*see mgeo attitude.* --help\)\n", done.stderr)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("mgeo att", ["attitude"]),
        ("mgeo attitude ", ["show", "export", "check", "schema", "verify", "fly", "calibrate"]),
        ("mgeo attitude show plan.json --pick ", ["knee", "fastest", "best"]),
        ("mgeo attitude verify plan.json --se", ["--seed"]),
    ],
)
def test_completion(line, expected):
    assert offered(line) == expected


def test_plans_and_files_as_json(run, folder, front, tmp_path):
    plan = front.plan("best")
    found = json.loads(run("show", folder, "--pick", "best", "--json").stdout)
    page = (ROOT / "docs" / "command-line.md").read_text(encoding="utf-8")
    (row,) = re.findall(r"^\| `attitude show` \| (.*) \|$", page, re.MULTILINE)
    assert list(found) == re.findall(r"`(\w+)`", row)
    assert (found["t_end_s"], found["trace"]) == (plan.t_end, plan.trace)
    assert len(found["timeline"]) == len(plan.phases)
    assert len(found["least_observable"]) == 5
    file = tmp_path / "plan.json"
    assert json.loads(run("export", folder, file, "--json").stdout) == {"files": [str(file)]}
