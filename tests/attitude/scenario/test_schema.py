"""JSON Schema of scenario files: the schema and `Scenario.from_dict` accept the same tables."""

from __future__ import annotations

import json
import tomllib
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from jsonschema import Draft202012Validator
from mgeo_attitude.commands.app import app
from mgeo_attitude.scenario import Scenario, build_scenario_schema
from typer.testing import CliRunner

from .strategies import scenarios

ROOT = Path(__file__).parents[3]
SCHEMA = Draft202012Validator(
    build_scenario_schema(), format_checker=Draft202012Validator.FORMAT_CHECKER
)


def read_as_json(text: str) -> Any:
    """Return a TOML text as JSON types."""

    def convert(value: Any) -> Any:
        return value.isoformat() if isinstance(value, datetime) else value

    return json.loads(json.dumps(tomllib.loads(text), default=convert))


@pytest.mark.parametrize(
    "path",
    [
        *(p for p in (ROOT / "docs" / "scenarios").glob("*.toml") if p.stem != "suite"),
        *(ROOT / "problems/attitude/mgeo_attitude/scenario").glob("*.toml"),
    ],
    ids=lambda path: path.stem,
)
def test_schema_accepts_scenario_files_of_repository(path: Path) -> None:
    table = read_as_json(path.read_text(encoding="utf-8"))
    SCHEMA.validate(table)
    Scenario.from_dict(table)


@pytest.mark.parametrize(
    ("keys", "allowed"),
    [
        ({}, True),
        ({"object": "ISS", "degree": 5}, True),
        ({"degree": 16}, False),
        ({"interpolation": "cubic"}, False),
        ({"epoch": "2018"}, False),
    ],
)
def test_schema_restricts_keys_of_ephemeris_files(keys: dict[str, Any], allowed: bool) -> None:
    orbit = {"propagator": "file", "file": "iss.oem"} | keys
    assert SCHEMA.is_valid({"preset": "paper", "orbit": orbit}) == allowed


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(scenario=scenarios())
def test_schema_accepts_random_scenarios(scenario: Scenario) -> None:
    SCHEMA.validate(scenario.to_dict())
    SCHEMA.validate(read_as_json(scenario.to_toml()))


@pytest.mark.parametrize(
    "text",
    [
        "stepp = 1.0",
        "step = true",
        "epoch = 2018",
        "objectives = 'trace'",
        "orbit.eccentricity = 1.0",
        "orbit.ecentricity = 0.1",
        "trace_weights.attitude = -1",
        "trace_weights.mag.bias = '1'",
        "[[sensors]]\nkind = 'sunsensor'",
        "[[sensors]]\nkind = 'sun-sensor'\nnoise_nt = 1.0",
        "[[path_constraints]]\nhalf_angle_deg = 180.0",
        "[[path_constraints]]\nboresight = [1, 0, 0]\nhalf_angle_deg = 9.0\nsense = 'keep'",
    ],
)
def test_schema_and_from_dict_reject_invalid_keys_and_values(text: str) -> None:
    table = read_as_json("" if text.startswith("preset") else "preset = 'paper'\n") | read_as_json(
        text
    )
    assert not SCHEMA.is_valid(table)
    with pytest.raises((ValueError, TypeError)):
        Scenario.from_dict(table)


@pytest.mark.parametrize("key", ["epoch", "duration", "orbit", "sensors"])
def test_keys_without_default_are_required_without_preset(key: str) -> None:
    table = Scenario.paper().to_dict()
    del table[key]
    assert not SCHEMA.is_valid(table)
    assert SCHEMA.is_valid(table | {"preset": "paper"})


def test_saved_scenario_refers_to_schema_that_command_prints(tmp_path: Path) -> None:
    Scenario.paper().save(tmp_path / "mine.toml")
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    assert text.splitlines()[0] == "#:schema ./scenario.schema.json"
    result = CliRunner().invoke(app, ["schema"])
    assert json.loads(result.stdout) == build_scenario_schema()
