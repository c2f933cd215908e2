"""What docs/plans.md shows works as it stands there."""

import re
import shlex
from pathlib import Path

import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.plan import read_json
from mgeo_attitude.view.observability.alternatives import baselines
from typer.testing import CliRunner

from mgeo.cli.app import app

from .attitude.conftest import few_flights  # noqa: F401
from .benchmarks.baselines import ALIKE, DOCUMENT
from .benchmarks.table import BEGIN, END

TEXT = DOCUMENT.read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", TEXT, re.DOTALL)


@pytest.mark.slow
def test_the_commands_and_the_code(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for line in blocks("sh")[0].splitlines():
        program, *arguments = shlex.split(line)
        assert program == "mgeo"
        codes = {0}
        if arguments[0] == "solve":  # a few generations will do here, and a few flights
            arguments += ["--evaluations", "1080", "--quiet"]
        elif "verify" in arguments:
            arguments += ["--runs", "4"]
            codes = {0, 3}
        done = CliRunner().invoke(app, arguments)
        assert done.exit_code in codes, line + done.output + done.stderr
    made = ["plan.aem", "plan.csv", "plan.html", "plan.json", "plan.uplink.csv"]
    assert sorted(path.name for path in tmp_path.glob("plan.*")) == made
    by_commands = read_json("plan.json"), Path("plan.csv").read_bytes()
    (code,) = blocks("python")
    assert len(code.splitlines()) <= 10
    exec(code, {})
    assert "attitude x" in capsys.readouterr().out
    assert read_json("plan.json") == by_commands[0]
    assert Path("plan.csv").read_bytes() == by_commands[1]
    assert "ORIGINATOR = INPE\n" in Path("plan.aem").read_text(encoding="utf-8")


def test_the_tables_are_those_of_the_script():
    """Every baseline has its row, but for axes that are alike."""
    tables = TEXT.partition(BEGIN)[2].partition(END)[0]
    for name in baselines(Scenario.paper(), 600.0).keys() - {*ALIKE}:
        assert len(re.findall(rf"^\| {re.escape(name)} \|", tables, re.MULTILINE)) == 1
