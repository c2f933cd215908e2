"""Scenario files: exact round trips, comments, errors with file and key, safe saving."""

from __future__ import annotations

import errno
import os
import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from mgeo_attitude.fields.quantity import declared
from mgeo_attitude.scenario.initial import InitialConditions
from mgeo_attitude.scenario.of_others import EphemerisOrbit, Orbit, OrbitFile, TLEOrbit
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.settings import Convergence, ManeuverLimits
from mgeo_attitude.scenario.toml import PRESETS, ScenarioFileError
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.kinds import SENSORS
from mgeo_attitude.sensors.world import World

from .strategies import scenarios
from .test_orbit import ISS_1, ISS_2

SECTIONS = (
    Scenario, Orbit, TLEOrbit, EphemerisOrbit, OrbitFile, Gyro, InitialConditions,
    ManeuverLimits, Convergence, World, *SENSORS.values(),
)  # fmt: skip


@pytest.mark.parametrize("preset", PRESETS)
def test_presets_round_trip_exactly(preset: str) -> None:
    scenario = getattr(Scenario, preset)()
    assert Scenario.from_toml(scenario.to_toml()) == scenario
    assert Scenario.from_toml(f'preset = "{preset}"') == scenario


@pytest.mark.filterwarnings("ignore::mgeo_attitude.scenario.validity.Implausible")
@settings(max_examples=50, deadline=None)
@given(scenario=scenarios())
def test_scenarios_round_trip_exactly(scenario: Scenario) -> None:
    assert Scenario.from_toml(scenario.to_toml()) == scenario


def test_an_element_set_round_trips() -> None:
    orbit = f'propagator = "sgp4"\nline1 = "{ISS_1}"\nline2 = "{ISS_2}"'
    scenario = Scenario.from_toml(
        f'preset = "paper"\nepoch = 2008-09-20T00:00:00Z\n[orbit]\n{orbit}'
    )
    assert scenario.orbit == TLEOrbit(line1=ISS_1, line2=ISS_2)
    assert Scenario.from_toml(scenario.to_toml()) == scenario


def test_every_key_has_a_comment() -> None:
    lines = Scenario.paper().to_toml().splitlines()
    uncommented = [line for line in lines if " = " in line and " # " not in line]
    assert uncommented[1:] == []
    assert uncommented == [
        '# only what differs: preset = "paper" or "cubesat_1u" or "cubesat_6u" or '
        '"cubesat_6u_full" or "microsatellite"'
    ]


@pytest.mark.parametrize("section", SECTIONS)
def test_every_field_says_what_it_means(section: type) -> None:
    assert [key for key, (_, spec) in declared(section).items() if not spec.doc] == []


@pytest.mark.parametrize(
    "line",
    [
        "epoch = 2018-06-05T00:00:00Z # start of the run with its UTC offset; Z is UTC",
        "semi_major_axis = 7130982.0 # semi-major axis: > 0 m",
        "eccentricity = 0.001111 # eccentricity: in [0, 1)",
        "rate_random_walk = 3e-08 # rate random walk that drives the bias, 1-sigma per axis, alike "
        "or of each: >= 0 rad/s^1.5",
        f'kind = "magnetometer" # one of {", ".join(map(repr, SENSORS))}',
        "# The blocks: attitude, gyro.bias, sun.misalignment, sun.bias, mag.misalignment, mag.bias",
    ],
)
def test_comments_give_meaning_unit_and_range(line: str) -> None:
    assert line in Scenario.paper().to_toml().splitlines()


def test_weights_may_be_written_with_dots() -> None:
    scenario = Scenario.from_toml('preset = "paper"\n[trace_weights]\nmag.bias = 0\nattitude = 2')
    assert dict(scenario.trace_weights) == {"mag.bias": 0.0, "attitude": 2.0}
    assert Scenario.from_toml(scenario.to_toml()) == scenario


def test_an_epoch_with_an_offset_is_converted_to_utc() -> None:
    scenario = Scenario.from_toml('preset = "paper"\nepoch = 2018-06-04T21:00:00-03:00')
    assert scenario == Scenario.paper()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("orbit.eccentricity = 1.2", "orbit.eccentricity = 1.2: expected a number in [0, 1)"),
        ("orbit.semi_major_axis = 6.3e6", "orbit.semi_major_axis = 6300000.0: expected a perigee "),
        ("orbit.eccentricity = nan", "orbit.eccentricity = nan: expected a number in [0, 1)"),
        ("duration = inf", "duration = inf: expected a number > 0 s"),
        ("step = true", "step = True: expected a number > 0 s"),
        ("step = '1'", "step = '1': expected a number > 0 s"),
        ("step = 7", "convergence.window = 300.0: expected a multiple of step = 7.0 s"),
        ("epoch = 2018-06-05", "epoch = datetime.date(2018, 6, 5): expected a date and time with"),
        ("epoch = 2018-06-05T00:00:00", "epoch = '2018-06-05T00:00:00': expected a UTC offset"),
        (
            "epoch = 2030-01-01T00:00:00Z",
            "epoch = '2030-01-01T00:00:00+00:00': expected a run of duration = 11984.0 s inside "
            "the field model IGRF-14, from 1900-01-01 to 2030-01-01 UTC",
        ),
        (
            "[[sensors]]\nkind = 'magnetometer'\nnoise_nt = -500",
            "sensors[0].noise_nt = -500: expected a number > 0 nT",
        ),
        (
            "[[sensors]]\nkind = 'magnetometer'\n[[sensors]]\nkind = 'magnetometer'",
            "sensors[1].name = 'mag': expected a name that no other sensor has, nor gyro or world",
        ),
        (
            "[[sensors]]\nkind = 'magnetometer'\nsample_interval = 1.5",
            "sensors[0].sample_interval = 1.5: expected a multiple of step = 1.0 s",
        ),
        (
            "step = 2.0\n[[sensors]]\nkind = 'magnetometer'\nsample_interval = 1",
            "sensors[0].sample_interval = 1.0: expected a multiple of step = 2.0 s",
        ),
        (
            "[[sensors]]\nkind = 'magnetometer'\nsample_interval = 20_000",
            "sensors[0].sample_interval = 20000.0: expected at most duration = 11984.0 s",
        ),
        (
            "[[sensors]]\nkind = 'magnetometer'\nsample_interval = 0",
            "sensors[0].sample_interval = 0: expected nothing or a number > 0 s",
        ),
        (
            "[[sensors]]\nkind = 'magnetometer'\nconsidered = ['field_error']",
            "world.considered[0] = 'field_error': unknown state (known: )",
        ),
        (
            "[[sensors]]\nkind = 'magnetometer'\nconsidered = ['bias', 'bias']",
            "sensors[0].considered[1] = 'bias': expected each one once",
        ),
        (
            "gyro.considered = ['biass']",
            "gyro.considered[0] = 'biass': unknown state; did you mean",
        ),
        (
            "[world]\nalbedo = 0.1\nalbedo_correlation_time = 0",
            "world.albedo_correlation_time = 0: expected a number > 0 s",
        ),
        ("[[sensors]]\nkind = 'radar'", "sensors[0].kind = 'radar': unknown kind (known: 'sun-"),
        ("[gyro]\nbias_decays = 1", "gyro.bias_decays: unknown key; did you mean 'bias_d"),
    ],
)
def test_an_error_names_file_and_key(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "scenario.toml"
    path.write_text(f'preset = "paper"\n{text}\n', encoding="utf-8")
    with pytest.raises(ScenarioFileError) as caught:
        Scenario.from_toml(path)
    assert str(caught.value).startswith(f"{path}: {message}")


@pytest.mark.parametrize("text", ["", "\n", "# a comment only\n"])
def test_an_empty_file_is_told_the_least_it_can_say(tmp_path: Path, text: str) -> None:
    path = tmp_path / "scenario.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ScenarioFileError) as caught:
        Scenario.from_toml(path)
    assert str(caught.value) == f'{path}: empty; the least it can say is preset = "paper"'


def test_what_is_no_toml_is_told_the_line(tmp_path: Path) -> None:
    path = tmp_path / "scenario.toml"
    path.write_text('preset = "paper"\nstep 1\n', encoding="utf-8")
    with pytest.raises(ScenarioFileError) as caught:
        Scenario.from_toml(path)
    assert str(caught.value).startswith(f"{path}: not TOML: ")
    assert "line 2" in str(caught.value)


def test_what_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scenario.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ScenarioFileError) as caught:
        Scenario.from_toml(path)
    assert str(caught.value).startswith(f"{path}: not TOML, which is UTF-8: ")


def test_a_file_may_be_named_by_a_string(tmp_path: Path) -> None:
    path = tmp_path / "scenario.toml"
    path.write_text('preset = "cubesat_6u"', encoding="utf-8")
    assert Scenario.from_toml(str(path)) == Scenario.cubesat_6u()
    with pytest.raises(FileNotFoundError, match=r"missing\.toml"):
        Scenario.from_toml(str(tmp_path / "missing.toml"))


def test_a_byte_order_mark_is_no_obstacle(tmp_path: Path) -> None:
    path = tmp_path / "scenario.toml"
    path.write_text('preset = "paper"', encoding="utf-8-sig")
    assert Scenario.from_toml(path) == Scenario.paper()


def test_a_name_without_suffix_is_taken_for_text_and_says_so() -> None:
    with pytest.raises(ScenarioFileError, match=r"a file's name would end in \.toml"):
        Scenario.from_toml("runs/scenario")


def test_saving_replaces_the_file_as_a_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "scenario.toml"
    Scenario.paper().save(path)
    Scenario.cubesat_6u().save(path)
    assert Scenario.from_toml(path) == Scenario.cubesat_6u()
    assert path.read_bytes().count(b"\r") == 0

    def full_disk(_: int) -> None:
        raise OSError(errno.ENOSPC, "no space left")

    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(OSError, match="no space left"):
        Scenario.paper().save(path)
    assert Scenario.from_toml(path) == Scenario.cubesat_6u()
    assert os.listdir(tmp_path) == ["scenario.toml"]


def test_a_saved_scenario_is_plain_toml(tmp_path: Path) -> None:
    path = tmp_path / "scenario.toml"
    Scenario.paper().save(path)
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    assert table | {"epoch": None} == Scenario.paper().to_dict() | {"epoch": None}
    assert table["epoch"] == Scenario.paper().epoch
