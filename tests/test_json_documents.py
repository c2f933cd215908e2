"""The output of ``--json`` and the JSON files satisfy the schemas that `mgeo schema` prints."""

import json
import re
from pathlib import Path

import jsonschema
import pandas as pd
import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.validation.documents import collect_documents

SCENARIO = """
preset = "paper"
duration = 900.0
[convergence]
window = 60.0
[[path_constraints]]
boresight = [0.0, 0.0, -1.0]
half_angle_deg = 1.0
"""
IMPOSSIBLE = 'preset = "paper"\nduration = 900.0\nrequired_sigma."mag.bias_nt" = 0.001\n'
STUDY = """
title = "Two algorithms"
evaluations = 40
seeds = 2
[[problems]]
name = ["pymoo:zdt1", "pymoo:zdt2"]
[[algorithms]]
name = ["mgeo-real", "nsga2"]
"""

#: Documents of commands that need no long run, with the arguments and the exit code.
QUICK = {
    "problems": (["problems"], 0),
    "algorithms": (["algorithms"], 0),
    "algorithm": (["algorithms", "mgeo-real"], 0),
    "solve": (["solve", "pymoo:bnh", "--evaluations", "40", "--out", "bnh"], 0),
    "solve-dry-run": (["solve", "pymoo:zdt1", "--dry-run"], 0),
    "study-dry-run": (["study", "study.toml", "--dry-run"], 0),
    "suite-catalog": (["suite", "catalog"], 0),
}
#: Documents of runs, plans and telemetry, in the order of the work.
SLOW = {
    "solve": (["solve", "attitude", "--scenario", "mine.toml", "--evaluations", "200"], 0),
    "report": (["report", "run"], 0),
    "study": (["study", "study.toml", "--jobs", "1"], 0),
    "solve-impossible": (["solve", "attitude", "--scenario", "impossible.toml"], 3),
    "attitude-show": (["attitude", "show", "run"], 0),
    "attitude-export": (["attitude", "export", "run", "plan.json"], 0),
    "attitude-check": (["attitude", "check", "mine.toml", "--plans", "1"], 0),
    "attitude-verify": (["attitude", "verify", "run", "--monte-carlo", "3"], None),
    "attitude-fly": (["attitude", "fly", "run", "--out", "t.csv", "--truth", "truth.json"], 0),
    "attitude-calibrate": (["attitude", "calibrate", "t.csv", "--plan", "run", "--out", "c"], 0),
    "attitude-calibrate-refused": (["attitude", "calibrate", "fast.csv", "--all"], 2),
    "suite-conclude": (["suite", "conclude", "suite"], 0),
}
FILES = {
    "run.json": "run/run.json",
    "plan.json": "plan.json",
    "truth.json": "truth.json",
    "calibration.json": "c/calibration.json",
}


def print_json(arguments, code):
    done = CliRunner().invoke(app, [*arguments, "--json"], prog_name="mgeo")
    assert code is None or done.exit_code == code, done.output + done.stderr
    return json.loads(done.stdout)


def validate(document, name):
    schema = collect_documents()[name].build_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(document, schema)


@pytest.mark.parametrize("name", QUICK)
def test_quick_commands(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("study.toml").write_text(STUDY)
    validate(print_json(*QUICK[name]), name)


@pytest.mark.slow
def test_commands_with_runs_and_their_files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("study.toml").write_text(STUDY)
    Path("mine.toml").write_text(SCENARIO)
    Path("impossible.toml").write_text(IMPOSSIBLE)
    suite = ["solve", "suite", "--evaluations", "300", "--out", "suite", "--quiet"]
    assert CliRunner().invoke(app, suite, prog_name="mgeo").exit_code == 0
    for name, (arguments, code) in SLOW.items():
        out = ["--out", "run"] if name == "solve" else []
        if name == "attitude-calibrate-refused":
            write_fast_telemetry("t.csv", "fast.csv")
            out = ["--scenario", "mine.toml"]
        validate(print_json([*arguments, *out], code), name)
    for name, path in FILES.items():
        validate(json.loads(Path(path).read_text()), name)


def write_fast_telemetry(source, target):
    """Write telemetry whose body rates are 3600 times too large."""
    table = pd.read_csv(source)
    table[["gyro_x", "gyro_y", "gyro_z"]] *= 3600.0
    table.to_csv(target, index=False)


def test_every_document_is_validated():
    # The explorer prints its document while its server runs; tests/mgeo/cli/test_explore.py has it.
    assert {*QUICK, *SLOW, *FILES, "explore"} == set(collect_documents())


def list_keys(schema):
    tables = [schema, *schema.get("$defs", {}).values()]
    return [(key, entry) for table in tables for key, entry in table["properties"].items()]


@pytest.mark.parametrize("name", list(collect_documents()))
def test_every_key_is_explained(name):
    for key, entry in list_keys(collect_documents()[name].build_schema()):
        assert entry["description"], key
        assert re.fullmatch("[a-z][a-z0-9_]*", key)


def test_command_prints_schemas():
    names = CliRunner().invoke(app, ["schema"], prog_name="mgeo").stdout.split()
    assert names == ["study.toml", *collect_documents()]
    for name in names:
        printed = CliRunner().invoke(app, ["schema", name], prog_name="mgeo").stdout
        jsonschema.Draft202012Validator.check_schema(json.loads(printed))
