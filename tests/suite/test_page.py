"""The page on sensor suites: its code runs, and its files are what it says."""

import re
import shlex
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from mgeo_suite import SensorSuiteProblem
from mgeo_suite.objectives import OBJECTIVES
from mgeo_suite.problem import PRESETS
from mgeo_suite.view import conclusions
from typer.testing import CliRunner

from mgeo.cli.app import app

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "suite.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.slow
def test_the_commands_are_there(tmp_path, monkeypatch):
    monkeypatch.chdir(DOCS.parent)
    lines = [line for block in blocks("sh") for line in block.splitlines() if "solve" in line]
    assert len(lines) == 2
    for line in lines:
        arguments = shlex.split(line)[1:]
        place = ["--out", str(tmp_path / "run"), "--dry-run"]
        done = CliRunner().invoke(app, [*arguments, *place])
        assert done.exit_code == 0, done.output


@pytest.mark.slow
def test_the_conclusions_are_those_of_the_stored_front():
    problem = SensorSuiteProblem()
    table = pd.read_csv(DOCS / "fronts" / "suite.csv").to_numpy()
    lines = conclusions(problem, table[:, :-2], table[:, -2:], [10.0, 30.0, 60.0])
    assert "\n".join(lines) in PAGE
    assert problem.evaluate(table[:, :-2]) == pytest.approx(table[:, -2:], rel=1e-9)


def test_what_the_page_says_of_the_front():
    table = pd.read_csv(DOCS / "fronts" / "suite.csv")
    price, accuracy, tracker = table.iloc[:, -2], table.iloc[:, -1], table["star tracker"] > 0
    assert accuracy[price < 14.8].min() > 0.03
    assert tracker[price >= 14.8].all()
    assert not tracker[price < 14.8].any()
    boom = table["magnetometer"] == 2
    assert [*table.index[boom]] == [len(table) - 1]  # the dearest alone has it
    assert accuracy.iloc[-1] > 0.999 * accuracy.iloc[-2]
    assert (table["gyro"][price <= 6.8] == 0).all()
    assert (table["gyro"][~tracker & (price >= 8.3)] == 1).all()
    first = table[tracker].iloc[0]
    assert (first["gyro"], first["magnetometer"]) == (0, 0)
    assert np.diff(accuracy[price <= 6.8]).max() < 0
    with_tracker = table[tracker].groupby("gyro").last()
    assert (with_tracker.index == [0, 1, 2]).all()


def test_objectives_presets_and_scenario_are_told():
    for name in (*OBJECTIVES, *PRESETS):
        assert f"`{name}`" in PAGE
    table = tomllib.loads((DOCS / "scenarios" / "suite.toml").read_text(encoding="utf-8"))
    assert SensorSuiteProblem.from_options(table).objectives == ("price", "mass", "t_required")
