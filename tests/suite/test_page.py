"""Documentation page on sensor suites: its commands, and the results that it quotes."""

import re
import shlex
from pathlib import Path

import pandas as pd
import pytest
from mgeo_suite import SensorSuiteProblem
from mgeo_suite.front_summary import find_best_suites
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
def test_page_quotes_the_summary_of_the_stored_front():
    problem = SensorSuiteProblem()
    table = pd.read_csv(DOCS / "fronts" / "suite.csv").to_numpy()
    for suite in find_best_suites(problem, table[:, :-2], table[:, -2:], [10.0, 30.0, 60.0]):
        assert f"{suite['price_keur']:.3g}" in PAGE
        assert f"{suite['attitude_1sigma_deg']:.2g}" in PAGE
        assert suite["suite"] in PAGE
    assert problem.evaluate(table[:, :-2]) == pytest.approx(table[:, -2:], rel=1e-9)
