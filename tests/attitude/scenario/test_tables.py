"""Scenarios as nested tables: round trips, presets with overrides, keys that are refused."""

from __future__ import annotations

import copy
import dataclasses
import json
from datetime import UTC, datetime
from typing import Any

import pytest
from hypothesis import given, settings
from mgeo_attitude.fields.quantity import InvalidType, InvalidValue
from mgeo_attitude.scenario.of_others import KeyProblem, Orbit, TLEOrbit
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.toml import PRESETS
from mgeo_attitude.sensors import Gyro, Sensor, StarTracker, SunSensor

from .strategies import scenarios
from .test_orbit import ISS_1, ISS_2

KNOWN = ", ".join(map(repr, PRESETS))
PAPER = {"preset": "paper"}


@pytest.mark.slow
@settings(max_examples=50, deadline=None)
@given(scenario=scenarios())
def test_tables_round_trip_through_json(scenario: Scenario) -> None:
    assert Scenario.from_dict(json.loads(json.dumps(scenario.to_dict()))) == scenario


def test_reading_leaves_the_table_alone() -> None:
    table = PAPER | {"orbit": {"eccentricity": 0.01}, "sensors": [{"kind": "star-tracker"}]}
    before = copy.deepcopy(table)
    Scenario.from_dict(table)
    assert table == before


def test_overrides_change_only_what_they_name() -> None:
    paper = Scenario.paper()
    scenario = Scenario.from_dict(
        PAPER | {"name": "mine", "orbit": {"propagator": "j2", "eccentricity": 0.01}}
    )
    expected = paper.to_dict()
    expected["name"] = "mine"
    expected["orbit"] |= {"propagator": "j2", "eccentricity": 0.01}
    assert scenario.to_dict() == expected


def test_a_list_of_sensors_replaces_the_presets() -> None:
    scenario = Scenario.from_dict(PAPER | {"sensors": [{"kind": "star-tracker"}]})
    assert scenario.sensors == (StarTracker(),)


def test_a_sensor_over_a_preset_takes_what_it_leaves_out_from_there() -> None:
    sun, mag = Scenario.cubesat_6u().sensors

    def read(*sensors: dict[str, Any]) -> tuple[Sensor, ...]:
        return Scenario.from_dict({"preset": "cubesat_6u", "sensors": [*sensors]}).sensors

    assert read({"kind": "sun-sensor", "name": "sun"}, {"kind": "magnetometer"}) == (sun, mag)
    assert read({"name": "mag"}, {"name": "sun", "noise_deg": 0.3}) == (
        mag,
        dataclasses.replace(sun, noise_deg=0.3),
    )
    # a new name: the preset's only one of the kind
    assert read(
        {"kind": "sun-sensor", "name": "left"},
        {"kind": "sun-sensor", "name": "right", "boresight": [1.0, 0.0, 0.0]},
    ) == (
        dataclasses.replace(sun, name="left"),
        dataclasses.replace(sun, name="right", boresight=(1.0, 0.0, 0.0)),
    )
    # a kind that the preset has not, whatever its name
    assert read({"kind": "star-tracker", "name": "sun"}) == (StarTracker(name="sun"),)


def test_a_sensor_without_a_preset_takes_the_defaults_of_its_kind() -> None:
    table = Scenario.cubesat_6u().to_dict() | {"sensors": [{"kind": "sun-sensor", "name": "sun"}]}
    assert Scenario.from_dict(table).sensors == (SunSensor(name="sun"),)


def test_an_element_set_replaces_the_presets_elements() -> None:
    orbit = {"propagator": "sgp4", "line1": ISS_1, "line2": ISS_2}
    scenario = Scenario.from_dict(PAPER | {"epoch": "2008-09-20T12:00:00Z", "orbit": orbit})
    assert scenario.orbit == TLEOrbit(line1=ISS_1, line2=ISS_2)
    assert scenario.to_dict()["orbit"] == orbit
    assert Scenario.from_dict(scenario.to_dict()) == scenario


def test_weights_come_flat_or_nested() -> None:
    flat = PAPER | {"trace_weights": {"mag.bias": 0.0, "attitude": 2.0}}
    nested = PAPER | {"trace_weights": {"mag": {"bias": 0.0}, "attitude": 2.0}}
    assert Scenario.from_dict(flat) == Scenario.from_dict(nested)


def test_an_epoch_is_a_string_or_a_datetime() -> None:
    for epoch in ("2020-01-02T03:04:05Z", datetime(2020, 1, 2, 3, 4, 5, tzinfo=UTC)):
        scenario = Scenario.from_dict(PAPER | {"epoch": epoch})
        assert scenario.epoch == datetime(2020, 1, 2, 3, 4, 5, tzinfo=UTC)
        assert scenario.to_dict()["epoch"] == "2020-01-02T03:04:05Z"


def test_what_has_a_default_may_be_left_out() -> None:
    paper = Scenario.paper().to_dict()
    required = {key: paper[key] for key in ("epoch", "duration", "orbit", "sensors")}
    del required["orbit"]["propagator"]
    scenario = Scenario.from_dict(required)
    assert scenario.name == "custom"
    assert scenario.gyro == Gyro()
    assert isinstance(scenario.orbit, Orbit)
    assert scenario.orbit.propagator == "two-body"


@pytest.mark.parametrize("key", ["epoch", "duration", "orbit", "sensors"])
def test_a_missing_key_is_named(key: str) -> None:
    table = Scenario.paper().to_dict()
    del table[key]
    with pytest.raises(KeyProblem, match=f"^{key}: missing; expected "):
        Scenario.from_dict(table)


def test_a_missing_key_of_a_section_says_what_it_takes() -> None:
    table = Scenario.paper().to_dict()
    del table["orbit"]["eccentricity"]
    with pytest.raises(KeyProblem) as caught:
        Scenario.from_dict(table)
    assert str(caught.value) == (
        "orbit.eccentricity: missing; expected a number in [0, 1) (eccentricity)"
    )


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ({"stepp": 1.0}, "stepp: unknown key; did you mean 'step'? (known: 'preset', 'name',"),
        ({"zzz": 1.0}, "zzz: unknown key (known: 'preset', 'name',"),
        (
            {"orbit": {"ecentricity": 0.1}},
            "orbit.ecentricity: unknown key; did you mean 'eccentricity'? (known: 'propagator',",
        ),
        (
            {"orbit": {"propagator": "sgp4", "line1": ISS_1, "line_2": ISS_2}},
            "orbit.line_2: unknown key; did you mean 'line2'? (known: 'propagator', 'line1',",
        ),
        (
            {"gyro": {"bias": 1.0}},
            "gyro.bias: unknown key; did you mean 'bias_instability_deg_per_h'",
        ),
        ({"initial": {"attitude": 1.0}}, "initial.attitude: unknown key; did you mean 'attitude_"),
        ({"maneuvers": {"counts": 1}}, "maneuvers.counts: unknown key; did you mean 'count'?"),
        ({"convergence": {"windows": 1}}, "convergence.windows: unknown key; did you mean 'window"),
        (
            {"sensors": [{"kind": "star-tracker"}, {"kind": "sun-sensor", "noise": 1.0}]},
            "sensors[1].noise: unknown key; did you mean 'noise_deg'? (known: 'kind', 'name',",
        ),
        ({"sensors": [{"name": "a"}]}, "sensors[0].kind: missing (known: 'sun-sensor',"),
        (
            {"trace_weights": {"mag.bias": 1.0, "mag": {"bias": 1.0}}},
            "trace_weights.mag.bias: given twice",
        ),
    ],
)
def test_keys_that_are_refused(override: dict[str, Any], message: str) -> None:
    with pytest.raises(KeyProblem) as caught:
        Scenario.from_dict(PAPER | override)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ({"gyro": {"bias_deg_s": 0.01}}, "gyro.bias_deg_s: is now called 'initial_bias_deg_s'"),
        (
            {"gyro": {"angle_random_walk_deg_sqrt_h": 0.01}},
            "gyro.angle_random_walk_deg_sqrt_h: is now called 'angle_random_walk_deg_per_sqrt_h'",
        ),
        (
            {"sensors": [{"kind": "sun-sensor"}, {"kind": "magnetometer", "bias_nt": 9.0}]},
            "sensors[1].bias_nt: is now called 'initial_bias_nt'",
        ),
        (
            {"sensors": [{"kind": "star-tracker", "misalignment_deg": 1.0}]},
            "sensors[0].misalignment_deg: is now called 'initial_misalignment_deg'",
        ),
    ],
)
def test_keys_of_older_files_are_told_the_new_ones(override: dict[str, Any], message: str) -> None:
    with pytest.raises(KeyProblem) as caught:
        Scenario.from_dict(PAPER | override)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("override", "message"),
    [
        (
            {"preset": "papers"},
            "preset = 'papers': unknown preset; did you mean 'paper'? (known: 'paper', 'cubes",
        ),
        (
            {"preset": 6},
            f"preset = 6: unknown preset (known: {KNOWN})",
        ),
        (
            {"preset": []},
            f"preset = []: unknown preset (known: {KNOWN})",
        ),
        (
            {"orbit": {"propagator": "j22"}},
            "orbit.propagator = 'j22': unknown propagator; did you mean 'j2'? (known: 'two-body', "
            "'j2', 'sgp4', 'mean-elements', 'ephemeris', 'file', 'ephemeris-file')",
        ),
        (
            {"sensors": [{"kind": "sunsensor"}]},
            "sensors[0].kind = 'sunsensor': unknown kind; did you mean 'sun-sensor'? (known: ",
        ),
        ({"sensors": [{"kind": 1}]}, "sensors[0].kind = 1: unknown kind (known: "),
        (
            {"sensors": [{"kind": "sun-sensor", "noise_deg": -2.0}]},
            "sensors[0].noise_deg = -2.0: expected a number > 0 deg",
        ),
        ({"orbit": {"eccentricity": 1.2}}, "orbit.eccentricity = 1.2: expected a number in [0, 1)"),
        ({"maneuvers": {"count": 0}}, "maneuvers.count = 0: expected an integer in [1, 100]"),
        (
            {"convergence": {"relative_decrease": 1.0}},
            "convergence.relative_decrease = 1.0: expected a number in (0, 1)",
        ),
        (
            {"epoch": "5 June 2018"},
            "epoch = '5 June 2018': expected a date and time with UTC offset, such as 2018-06-05T",
        ),
        ({"epoch": "2018-06-05T00:00:00"}, "epoch = '2018-06-05T00:00:00': expected a UTC offset"),
    ],
)
def test_values_that_are_refused(override: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidValue) as caught:
        Scenario.from_dict(PAPER | override)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ({"orbit": 3}, "orbit = 3: expected a table"),
        ({"gyro": []}, "gyro = []: expected a table"),
        ({"sensors": {"kind": "sun-sensor"}}, "sensors = {'kind': 'sun-sensor'}: expected a list"),
        ({"sensors": ["sun-sensor"]}, "sensors[0] = 'sun-sensor': expected a table"),
        ({"trace_weights": [1.0]}, "trace_weights = [1.0]: expected a table"),
        ({"epoch": 2018}, "epoch = 2018: expected a date and time"),
        (
            {"gyro": {"initial_bias_deg_s": True}},
            "gyro.initial_bias_deg_s = True: expected a number > 0 deg/s",
        ),
        (
            {"initial": {"attitude_deg": "5"}},
            "initial.attitude_deg = '5': expected a number in",
        ),
        ({"maneuvers": {"count": 3.0}}, "maneuvers.count = 3.0: expected an integer in [1, 100]"),
    ],
)
def test_wrong_types_are_type_errors(override: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidType) as caught:
        Scenario.from_dict(PAPER | override)
    assert str(caught.value).startswith(message)
