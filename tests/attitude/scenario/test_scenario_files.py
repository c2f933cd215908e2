"""Scenarios from tables and files: round trips, presets with overrides, and errors."""

from __future__ import annotations

import copy
import dataclasses
import json
import pickle
import tomllib
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from mgeo_attitude.scenario import Orbit, TLEOrbit
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.toml import PRESETS, ScenarioFileError
from mgeo_attitude.sensors import Gyro, Sensor, StarTracker, SunSensor

from .strategies import scenarios
from .test_orbit import ISS_1, ISS_2

PAPER = {"preset": "paper"}


@pytest.mark.parametrize("preset", PRESETS)
def test_presets_round_trip_exactly(preset: str) -> None:
    scenario = getattr(Scenario, preset)()
    assert Scenario.from_toml(scenario.to_toml()) == scenario
    assert Scenario.from_toml(f'preset = "{preset}"') == scenario


@pytest.mark.filterwarnings("ignore::mgeo_attitude.scenario.validity.ImplausibleValue")
@settings(max_examples=20, deadline=None)
@given(scenario=scenarios())
def test_scenarios_round_trip_exactly(scenario: Scenario) -> None:
    assert Scenario.from_toml(scenario.to_toml()) == scenario
    assert Scenario.from_dict(json.loads(json.dumps(scenario.to_dict()))) == scenario
    copied = pickle.loads(pickle.dumps(scenario))
    assert (copied, hash(copied)) == (scenario, hash(scenario))


def test_from_dict_does_not_modify_table() -> None:
    table = PAPER | {"orbit": {"eccentricity": 0.01}, "sensors": [{"kind": "star-tracker"}]}
    before = copy.deepcopy(table)
    Scenario.from_dict(table)
    assert table == before


def test_overrides_change_only_their_keys() -> None:
    orbit = {"propagator": "j2", "eccentricity": 0.01}
    expected = Scenario.paper().to_dict()
    expected["name"] = "mine"
    expected["orbit"] |= orbit
    assert Scenario.from_dict(PAPER | {"name": "mine", "orbit": orbit}).to_dict() == expected


def test_sensor_inherits_missing_keys_from_preset() -> None:
    sun, mag = Scenario.cubesat_6u().sensors

    def read(*sensors: dict[str, Any]) -> tuple[Sensor, ...]:
        return Scenario.from_dict({"preset": "cubesat_6u", "sensors": [*sensors]}).sensors

    assert read({"kind": "sun-sensor", "name": "sun"}, {"kind": "magnetometer"}) == (sun, mag)
    assert read({"name": "mag"}, {"name": "sun", "noise_deg": 0.3}) == (
        mag,
        dataclasses.replace(sun, noise_deg=0.3),
    )
    # A sensor with a new name inherits from the only sensor of its kind.
    assert read(
        {"kind": "sun-sensor", "name": "left"},
        {"kind": "sun-sensor", "name": "right", "boresight": [1.0, 0.0, 0.0]},
    ) == (
        dataclasses.replace(sun, name="left"),
        dataclasses.replace(sun, name="right", boresight=(1.0, 0.0, 0.0)),
    )
    # A kind that the preset does not contain uses defaults, whatever its name.
    assert read({"kind": "star-tracker", "name": "sun"}) == (StarTracker(name="sun"),)


def test_keys_with_default_are_optional_without_preset() -> None:
    paper = Scenario.paper().to_dict()
    table = {key: paper[key] for key in ("epoch", "duration", "orbit")}
    del table["orbit"]["propagator"]
    scenario = Scenario.from_dict(table | {"sensors": [{"kind": "sun-sensor"}]})
    assert (scenario.name, scenario.gyro, scenario.sensors) == ("custom", Gyro(), (SunSensor(),))
    assert isinstance(scenario.orbit, Orbit)
    assert scenario.orbit.propagator == "two-body"


def test_element_set_replaces_elements_of_preset() -> None:
    orbit = {"propagator": "sgp4", "line1": ISS_1, "line2": ISS_2}
    scenario = Scenario.from_dict(PAPER | {"epoch": "2008-09-20T12:00:00Z", "orbit": orbit})
    assert scenario.orbit == TLEOrbit(line1=ISS_1, line2=ISS_2)
    assert scenario.to_dict()["orbit"] == orbit
    assert Scenario.from_toml(scenario.to_toml()) == scenario


def test_trace_weights_may_be_dotted_or_nested() -> None:
    dotted = Scenario.from_dict(PAPER | {"trace_weights": {"mag.bias": 0.0, "attitude": 2.0}})
    nested = Scenario.from_toml('preset = "paper"\n[trace_weights]\nmag.bias = 0\nattitude = 2')
    assert dotted == nested
    assert dict(nested.trace_weights) == {"mag.bias": 0.0, "attitude": 2.0}


def test_epoch_may_be_string_or_datetime() -> None:
    for epoch in ("2020-01-02T03:04:05Z", datetime(2020, 1, 2, 3, 4, 5, tzinfo=UTC)):
        scenario = Scenario.from_dict(PAPER | {"epoch": epoch})
        assert scenario.epoch == datetime(2020, 1, 2, 3, 4, 5, tzinfo=UTC)
        assert scenario.to_dict()["epoch"] == "2020-01-02T03:04:05Z"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("stepp = 1", "stepp: unknown key; did you mean 'step'? (known: 'name',"),
        ("epoch = 2018-06-05T00:00:00", "epoch = '2018-06-05T00:00:00': expected a UTC offset"),
        ("orbit.eccentricity = 1.2", "orbit.eccentricity = 1.2: expected a number >= 0 and < 1"),
        ("orbit.propagator = 'j22'", "orbit.propagator = 'j22': unknown propagator; did you mean "),
        (f"orbit.line1 = '{ISS_1}'", "orbit.line2: missing; expected a string (second line"),
        ("gyro.considered = ['biass']", "gyro.considered[0] = 'biass': unknown state; did you"),
        ("sensors = ['sun']", "sensors[0] = 'sun': expected an instance of Sensor"),
        ("[[sensors]]\nkind = 'radar'", "sensors[0].kind = 'radar': unknown kind (known: 'sun-"),
        (
            "[[sensors]]\nkind = 'magnetometer'\n[[sensors]]\nkind = 'magnetometer'",
            "sensors[1].name = 'mag': expected no duplicates",
        ),
        (
            "[[sensors]]\nkind = 'magnetometer'\nsample_interval = 1.5",
            "sensors[0].sample_interval = 1.5: expected a multiple of step = 1.0 s",
        ),
        ("trace_weights = {'mag.bias' = 1, mag = {bias = 1}}", "trace_weights.mag.bias: given"),
    ],
)
def test_error_names_file_and_key(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "scenario.toml"
    path.write_text(f'preset = "paper"\n{text}\n', encoding="utf-8")
    with pytest.raises(ScenarioFileError) as error:
        Scenario.from_toml(path)
    assert str(error.value).startswith(f"{path}: {message}")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"# a comment only\n", 'empty; the shortest scenario is: preset = "paper"'),
        (b'preset = "paper"\nstep 1\n', "not TOML: .*line 2"),
        (b"\xff\xfe\x00", "not TOML: 'utf-8' codec"),
    ],
)
def test_error_names_file_that_is_not_a_scenario(
    tmp_path: Path, content: bytes, message: str
) -> None:
    path = tmp_path / "scenario.toml"
    path.write_bytes(content)
    with pytest.raises(ScenarioFileError, match=f"^{path}: {message}"):
        Scenario.from_toml(path)


def test_file_may_be_given_as_string(tmp_path: Path) -> None:
    path = tmp_path / "scenario.toml"
    path.write_text('preset = "cubesat_6u"', encoding="utf-8-sig")
    assert Scenario.from_toml(str(path)) == Scenario.cubesat_6u()
    with pytest.raises(FileNotFoundError, match=r"missing\.toml"):
        Scenario.from_toml(str(tmp_path / "missing.toml"))
    with pytest.raises(ScenarioFileError, match=r"a file name must end in \.toml"):
        Scenario.from_toml("runs/scenario")


def test_saved_scenario_is_valid_toml(tmp_path: Path) -> None:
    path = tmp_path / "scenario.toml"
    Scenario.paper().save(path)
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    assert table | {"epoch": None} == Scenario.paper().to_dict() | {"epoch": None}
