"""Element sets in files: messages in four notations, lines, several objects, and bad ones."""

from __future__ import annotations

import dataclasses
import json
import math
import sys
from collections.abc import Callable
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.environment.element_file import is_element_file, read_omm
from mgeo_attitude.environment.element_set import SGP4Error, gcrs_of
from mgeo_attitude.environment.times import instants
from mgeo_attitude.scenario import MeanElements, OrbitFile, TLEOrbit
from mgeo_attitude.settings.errors import InvalidValue
from sgp4 import exporter, omm
from sgp4.api import Satrec

from mgeo.plugins.problems import load_problem
from mgeo.store.scenario_file import read_scenario

from ..scenario.test_orbit import ISS_1, ISS_2, VANGUARD_1, VANGUARD_2, with_checksum

REFERENCE = Path(__file__).parents[1] / "reference"
OMM, TLE = REFERENCE / "cosmos-2584.omm", REFERENCE / "iss-2022-05-08.tle"
EPOCH = datetime(2026, 7, 21, 10, tzinfo=UTC)
ISS_EPOCH = datetime(2008, 9, 20, 12, 40, tzinfo=UTC)
TIMES = np.arange(0.0, 6001.0, 60.0)

(FIELDS,) = read_omm(OMM.read_text())
del FIELDS["CCSDS_OMM_VERS"]


def kvn(*messages: dict[str, str]) -> str:
    return "".join(
        "CCSDS_OMM_VERS = 2.0\n" + "".join(f"{k} = {v}\n" for k, v in fields.items())
        for fields in messages
    )


def xml(*messages: dict[str, str], namespace: str = "") -> str:
    parts = "".join(
        "<omm><body><segment><metadata>"
        f"<OBJECT_NAME>{fields['OBJECT_NAME']}</OBJECT_NAME></metadata><data><meanElements>"
        + "".join(f"<{k}>{v}</{k}>" for k, v in fields.items() if k[:4] != "OBJE")
        + "</meanElements></data></segment></body></omm>"
        for fields in messages
    )
    return f'<?xml version="1.0" encoding="UTF-8"?>\n<ndm{namespace}>{parts}</ndm>'


def table(*messages: dict[str, str]) -> str:
    """As catalogs write it, without what is the same for all."""
    keys = [k for k in messages[0] if k not in ("CENTER_NAME", "REF_FRAME", "TIME_SYSTEM")]
    return "\n".join([",".join(keys), *(",".join(m[k] for k in keys) for m in messages)])


def plain(text: str) -> str | float:
    """A number as JSON has it, if it can be one, and else the text."""
    try:
        return float(text) if "." in text or "E" in text else int(text)
    except ValueError:
        return text


NOTATIONS: dict[str, Callable[..., str]] = {
    "a.omm": kvn,
    "a.xml": xml,
    "b.xml": lambda *m: xml(*m, namespace=' xmlns="urn:ccsds:schema:ndmxml"'),
    "a.json": lambda *m: json.dumps([{k: plain(v) for k, v in each.items()} for each in m]),
    "a.csv": table,
}


def of(file: Path, **keys: Any) -> Any:
    return OrbitFile(file=str(file), **keys).for_run(EPOCH, 6000.0)


def renamed(number: str, name: str, designator: str = "2026-123A") -> dict[str, str]:
    return FIELDS | {"NORAD_CAT_ID": number, "OBJECT_NAME": name, "OBJECT_ID": designator}


def test_a_message_is_what_sgp4_makes_of_it() -> None:
    found = of(OMM)
    satellite = Satrec()
    omm.initialize(satellite, FIELDS)
    expected, motion = gcrs_of(satellite, instants(EPOCH, TIMES))
    position, velocity = found.propagate(EPOCH, TIMES)
    assert np.abs(position - expected).max() < 1e-6
    assert np.abs(velocity - motion).max() < 1e-9
    assert found.period == pytest.approx(86400.0 / 2.13103797, rel=1e-12)
    assert found.source.startswith("cosmos-2584.omm, COSMOS 2584 (704K) 2025-042A 63130, SHA-256 ")


def test_a_message_is_the_lines_of_the_same_elements(tmp_path: Path) -> None:
    """Lines have 8 decimals of a day, 0.4 ms or 3 m."""
    lines = TLEOrbit(line1=ISS_1, line2=ISS_2)
    fields = exporter.export_omm(Satrec.twoline2rv(ISS_1, ISS_2), "ISS (ZARYA)")
    (tmp_path / "iss.omm").write_text(kvn(fields))
    found = OrbitFile(file=str(tmp_path / "iss.omm")).for_run(ISS_EPOCH, 6000.0)
    assert isinstance(found, MeanElements)
    assert abs((found.epoch - lines.epoch).total_seconds()) < 1e-5
    both = [each.propagate(ISS_EPOCH, TIMES)[0] for each in (found, lines)]
    assert np.linalg.norm(both[0] - both[1], axis=1).max() < 5.0


@pytest.mark.parametrize("name", NOTATIONS)
def test_notations(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(NOTATIONS[name](FIELDS))
    found, expected = of(tmp_path / name), of(OMM)
    assert dataclasses.replace(found, source=expected.source) == expected
    (tmp_path / name).write_text(NOTATIONS[name](renamed("799501234", "NEW"), FIELDS))
    for wanted in ("799501234", "new"):
        assert " NEW " in of(tmp_path / name, object=wanted).source
    with pytest.raises(InvalidValue, match=r"2 objects: expected object, a name or number, of NEW"):
        of(tmp_path / name)
    with pytest.raises(InvalidValue, match=r"no object 'ISS': expected object, .* of NEW .*COSMOS"):
        of(tmp_path / name, object="ISS")


@pytest.mark.parametrize("name", ["vanguard-1.omm.csv", "vanguard-1.omm.xml"])
def test_messages_that_sgp4_reads_give_its_orbits(name: str) -> None:
    path = OMM.with_name(name)
    (fields,) = read_omm(path.read_text())
    epoch = datetime.fromisoformat(fields["EPOCH"]).replace(tzinfo=UTC)
    orbit = OrbitFile(file=str(path)).for_run(epoch, 6000.0)
    satellite = Satrec()
    omm.initialize(satellite, fields)
    expected, _ = gcrs_of(satellite, instants(epoch, TIMES))
    assert np.abs(orbit.propagate(epoch, TIMES)[0] - expected).max() < 1e-6
    assert "VANGUARD 1 1958-002B 5" in orbit.source or "VANGUARD 1 5" in orbit.source


@pytest.mark.filterwarnings("ignore:.*the field is not IGRF")  # 4 Earth radii away
def test_scenarios_of_files(tmp_path: Path) -> None:
    """By the key `file` alone, or by the propagator's names; what is kept needs no file."""
    (tmp_path / "real.omm").write_bytes(OMM.read_bytes())
    for propagator in ("", 'propagator = "file"\n', 'propagator = "ephemeris-file"\n'):
        path = tmp_path / "s.toml"
        path.write_text(
            'preset = "cubesat_6u"\nepoch = 2026-07-21T10:00:00Z\nduration = 6000.0\n'
            f'[orbit]\n{propagator}file = "real.omm"\n'
        )
        scenario = Scenario.from_toml(path)
        options = read_scenario("attitude", str(path))
        assert isinstance(scenario.orbit, MeanElements)
        assert Scenario.from_toml(scenario.to_toml()) == scenario
        assert load_problem("attitude", options).options() == options == scenario.to_dict()
    scenario = dataclasses.replace(scenario, step=60.0, duration=6000.0)
    radius = np.linalg.norm(Environment.from_scenario(scenario).position, axis=1)
    assert 25.4e6 < radius.min() < radius.max() < 25.6e6


@pytest.mark.parametrize(
    ("orbit", "expected"),
    [
        (
            {"propagator": "sgp4", "file": "a.omm"},
            "file: no key of propagator = 'sgp4', but of 'fi",
        ),
        (
            {"propagator": "file", "line1": ISS_1},
            "line1: no key of propagator = 'file', but of 'sg",
        ),
        ({"line1": ISS_1}, "line2: missing; expected a string (second line of the element set)"),
        ({"file": 3}, "file = 3: expected a string"),
        ({"propagator": None, "file": "a.omm"}, "propagator = None: unknown propagator"),
    ],
)
def test_keys_that_do_not_go_together(orbit: dict[str, Any], expected: str) -> None:
    with pytest.raises(InvalidValue) as caught:
        Scenario.from_dict({"preset": "cubesat_6u", "orbit": orbit})
    assert str(caught.value).startswith(f"orbit.{expected}")


def test_lines_with_blanks_at_their_ends() -> None:
    name, line1, line2 = TLE.read_text().splitlines()
    scenario = Scenario.from_toml(
        'preset="cubesat_6u"\nepoch=2022-05-09T00:00:00Z\nduration=3000.0\n[orbit]\n'
        f'propagator="sgp4"\nline1="{line1} "\nline2="{line2}"'
    )
    found = OrbitFile(file=str(TLE)).for_run(scenario.epoch, 3000.0)
    assert isinstance(found, TLEOrbit)
    assert dataclasses.replace(found, source=None) == scenario.orbit
    assert found.source is not None
    assert found.source.startswith(f"iss-2022-05-08.tle, {name} 1998-067A 25544, SHA-256 ")


def pair(number: str, day: str = "08264.51782528") -> str:
    line1, line2 = f"1 {number}{ISS_1[7:18]}{day}{ISS_1[32:]}", f"2 {number}{ISS_2[7:]}"
    return f"{with_checksum(line1)}\r\n{with_checksum(line2)}\r\n"


def test_files_of_lines(tmp_path: Path) -> None:
    """Names above or none, numbers with a letter, and of several sets the nearest in time."""
    path = tmp_path / "stations.txt"
    path.write_text(
        f"0 NEW\r\n{pair('T0001')}OLD (A)   \r\n{pair('25544', '08250.00000000')}"
        f"OLD (A)\r\n{pair('25544')}{pair('00005')}",
        newline="",
    )

    def source(wanted: str) -> Any:
        return OrbitFile(file=str(path), object=wanted).for_run(ISS_EPOCH, 6000.0).source

    for wanted in ("T0001", "270001", "new"):
        assert source(wanted).startswith("stations.txt, NEW 1998-067A T0001, ")
    for wanted in ("00005", "5"):
        assert source(wanted).startswith("stations.txt, 1998-067A 00005, ")
    found = OrbitFile(file=str(path), object="old (a)").for_run(ISS_EPOCH, 6000.0)
    assert isinstance(found, TLEOrbit)
    assert (found.line1, found.line2) == (ISS_1, ISS_2)
    with pytest.raises(InvalidValue) as caught:
        source("1998-067A")
    assert "3 objects '1998-067A': expected object, a name or number, of NEW 1998" in str(
        caught.value
    )
    with pytest.raises(
        InvalidValue, match="3 objects: expected object, a name or number, of NEW 19"
    ):
        source("")


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"REF_FRAME": "EME2000"}, "REF_FRAME = 'EME2000': expected TEME, as SGP4"),
        ({"MEAN_ELEMENT_THEORY": "DSST"}, "MEAN_ELEMENT_THEORY = 'DSST': expected SGP4 or SGP"),
        ({"EPHEMERIS_TYPE": "4"}, "EPHEMERIS_TYPE = '4': expected 0 or 2 or SGP or SGP4, as SGP4"),
        ({"BSTAR": ""}, "BSTAR: missing; expected the mean elements of SGP4"),
        ({"MEAN_MOTION": "x"}, "MEAN_MOTION = 'x': expected a number"),
        ({"ECCENTRICITY": "1.5"}, "ECCENTRICITY = 1.5: expected a number in [0, 1)"),
        ({"MEAN_MOTION": "18"}, "MEAN_MOTION = 18.0: expected a perigee above the Earth's surf"),
        ({"EPOCH": "2026"}, "time '2026': expected one such as 2018"),
        (
            {"EPOCH": "2026-05-21T09:30:22"},
            "epoch = '2026-05-21T09:30:22+00:00': expected an element set",
        ),
    ],
)
def test_messages_that_are_refused(tmp_path: Path, changes: dict[str, str], expected: str) -> None:
    path = tmp_path / "a.omm"
    path.write_text(kvn(FIELDS | changes))
    with pytest.raises(InvalidValue) as caught:
        of(path)
    assert str(caught.value).startswith(f"file = '{path}': ")
    assert expected in str(caught.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("<omm><MEAN_MOTION></omm>", "not XML: mismatched tag"),
        ('{"MEAN_MOTION": ', "Expecting value"),
        ('[1, "MEAN_MOTION"]', "1: expected a message, or a list of them, in JSON"),
        ("<omm id='CCSDS_OMM_VERS'/>", "expected a mean-elements message, and there is none"),
        ("OBJECT_NAME,MEAN_MOTION\nA,1", "A: EPOCH: missing"),
        (f"{VANGUARD_1}\n{ISS_2}", "expected the satellite number of line 1, '00005'"),
        (f"1 x\n{VANGUARD_2}", "'1 x': expected an epoch in columns 19-32"),
        ("[" * 100_000 + "MEAN_MOTION", "not a message: its brackets are nested too deeply"),
        (f"MEAN_MOTION\n{'9' * 200_000}", "not CSV: field larger than field limit"),
    ],
)
def test_texts_that_are_refused(tmp_path: Path, text: str, expected: str) -> None:
    path = tmp_path / "a.txt"
    path.write_text(text)
    with pytest.raises(InvalidValue) as caught:
        of(path)
    assert str(caught.value).startswith(f"file = '{path}': ")
    assert expected in str(caught.value)


@pytest.mark.parametrize("text", ["\n" * 300_000, "1 " + " " * 300_000, "1 x" + "\n" * 300_000])
def test_long_blanks_are_no_elements(text: str) -> None:
    """Patterns took squared time of them: minutes."""
    assert not is_element_file(text + "x")


def test_brackets_that_are_no_unit_stay() -> None:
    """So did that of units."""
    told = {"MEAN_MOTION": "15.1 [rev/day] ", "BSTAR": "[" * 300_000, "OBJECT_NAME": "A [b] [c]"}
    (found,) = read_omm("".join(f"{key} = {value}\n" for key, value in told.items()))
    assert found == {"MEAN_MOTION": "15.1", "BSTAR": "[" * 300_000, "OBJECT_NAME": "A [b]"}


def test_a_satellite_that_decays_within_the_run() -> None:
    """Case 28350 of Vallado et al. 2006, Cosmos 2405 in its last days."""
    text = (
        'preset="cubesat_6u"\nepoch={}\nduration={}\n[orbit]\n'
        'line1="1 28350U 04020A   06167.21788666  .16154492  76267-5  18678-3 0  8894"\n'
        'line2="2 28350  64.9977 345.6130 0024870 260.7578  99.9590 16.47856722116490"\n'
    )
    early = Scenario.from_toml(text.format("2006-06-16T05:13:45Z", 6000.0))
    radius = np.linalg.norm(early.orbit.propagate(early.epoch, TIMES)[0], axis=1)
    assert radius.min() > 6378136.3 + 100e3
    said = r"orbit\.line1 = .* at 2006-06-17T05:4[0-9:.]*Z, t = \d+ s, it says: mean eccentricity"
    with pytest.raises(ValueError, match=said):
        Scenario.from_toml(text.format("2006-06-17T04:30:00Z", 6000.0))
    table = early.to_dict()
    end = datetime(2006, 6, 17, 5, 45, tzinfo=UTC)
    for seconds, holds in ((-10.0, True), (120.0, False)):
        duration = 10.0 * math.floor(((end - early.epoch).total_seconds() + seconds) / 10.0)
        longer = table | {"step": 10.0, "duration": duration}
        if holds:
            orbit = Scenario.from_dict(longer).orbit
            orbit.propagate(early.epoch, np.arange(0.0, duration, 10.0))
        else:
            with pytest.raises(InvalidValue, match="SGP4 propagates through the run"):
                Scenario.from_dict(longer)


def test_without_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    found = of(OMM)
    monkeypatch.setitem(sys.modules, "sgp4.api", None)
    for orbit in (TLEOrbit(line1=ISS_1, line2=ISS_2), dataclasses.replace(found, epoch=ISS_EPOCH)):
        with pytest.raises(InvalidValue, match=r": an element set needs .* pip install sgp4$"):
            orbit.for_run(ISS_EPOCH, 60.0)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"epoch": datetime(2026, 7, 21)}, "epoch = '2026-07-21T00:00:00': expected a UTC offset"),
        ({"mean_motion_rev_day": 17.5}, "mean_motion_rev_day = 17.5: expected a perigee above"),
        ({"inclination_deg": 181.0}, "inclination_deg = 181.0: expected a number in [0, 180]"),
    ],
)
def test_elements_that_are_refused(changes: dict[str, Any], expected: str) -> None:
    with pytest.raises(InvalidValue) as caught:
        dataclasses.replace(of(OMM), **changes)
    assert str(caught.value).startswith(expected)


def test_beyond_the_run_that_was_checked() -> None:
    high = {"mean_motion_rev_day": 16.4, "bstar": 0.1, "eccentricity": 0.001}
    low = dataclasses.replace(of(OMM), **high)
    with pytest.raises(SGP4Error, match=r"^SGP4 error \d at t = "):
        low.propagate(low.epoch, np.arange(0.0, 864001.0, 600.0))
    with pytest.raises(
        InvalidValue, match=r"^epoch = '2026-07-21T09:30:22.148352\+00:00': .* at 20"
    ):
        low.for_run(low.epoch, 864000.0)


def test_elements_of_another_zone_are_the_same() -> None:
    found = of(OMM)
    zone = timezone(timedelta(hours=3))
    moved = dataclasses.replace(found, epoch=found.epoch.astimezone(zone))
    np.testing.assert_array_equal(
        moved.propagate(EPOCH, TIMES)[0], found.propagate(EPOCH, TIMES)[0]
    )
