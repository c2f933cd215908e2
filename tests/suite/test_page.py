"""Documentation page on sensor suites: its commands, and its conclusions."""

import re
import shlex
from pathlib import Path

import pandas as pd
import pytest
from mgeo_suite import SensorSuiteProblem
from typer.testing import CliRunner

from mgeo.cli.app import app

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "how-to/choose-sensors.md").read_text(encoding="utf-8")


def list_code_blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.slow
def test_commands_of_the_page_are_valid(tmp_path, monkeypatch):
    monkeypatch.chdir(DOCS.parent)
    lines = [
        line for block in list_code_blocks("sh") for line in block.splitlines() if "solve" in line
    ]
    assert len(lines) == 2
    for line in lines:
        arguments = shlex.split(line)[1:]
        options = ["--out", str(tmp_path / "run"), "--dry-run"]
        done = CliRunner().invoke(app, [*arguments, *options])
        assert done.exit_code == 0, done.output


@pytest.mark.slow
def test_conclusions_of_the_page_hold_for_the_stored_front():
    problem = SensorSuiteProblem()
    table = pd.read_csv(DOCS / "fronts" / "suite.csv").sort_values("price [kEUR]").to_numpy()
    X, F = table[:, : problem.n_var], table[:, problem.n_var :]
    assert problem.evaluate(X) == pytest.approx(F, rel=1e-9)
    accuracy = F[:, 1]
    names = [problem.suites.describe_suite(choice) for choice in problem.split_designs(X)[0]]
    has_tracker = ["star tracker" in name for name in names]
    assert [sigma <= 0.03 for sigma in accuracy] == has_tracker
    first = next(row for row, name in enumerate(names) if not name.startswith("mems gyro"))
    assert accuracy[first] < 0.7 * accuracy[first - 1]
    assert ["boom" in name for name in names] == [False] * (len(names) - 1) + [True]
    assert accuracy[-1] > 0.99 * accuracy[-2]
