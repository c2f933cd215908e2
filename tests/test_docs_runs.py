"""What docs/runs.md shows works as it stands there."""

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mgeo import read_record
from mgeo.cli.app import app
from mgeo.store.run_folder import read_run

from .attitude.conftest import few_flights  # noqa: F401

PAGE = (Path(__file__).parents[1] / "docs" / "runs.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


def test_the_python_examples_run_one_after_the_other(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "runs"}
    for code in blocks("python"):
        exec(code, names)
    assert re.fullmatch(r"(\d+) of 1000 failed: \{'F\[0\] = nan': \1\}\n", capsys.readouterr().out)
    assert list(names["table"]) == ["generation", *(f"x{i}" for i in range(1, 7)), "f1", "f2",
                                    "failed"]  # fmt: skip
    assert len(names["best"]) == 20


@pytest.mark.slow
def test_the_commands_do_what_the_page_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (commands,) = blocks("sh")
    budgets, fronts = [], []
    for command in commands.splitlines():
        program, *arguments = shlex.split(command)
        assert program == "mgeo"
        done = CliRunner().invoke(app, arguments)
        assert done.exit_code == 0, done.output
        run = read_run("runs/long")
        budgets.append(run.outcome.evaluations)
        fronts.append(run.outcome.F.tolist())
    assert budgets == [1056, 1056, 2112, 2880]
    assert fronts[0] == fronts[1]
    assert len(read_record("runs/long/evaluations")) == 2880
