"""Files of element sets in all notations, compared with the package sgp4, and invalid files."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mgeo_attitude.environment.element_set import SGP4Error, compute_gcrs_states
from mgeo_attitude.environment.times import compute_julian_dates
from mgeo_attitude.scenario import OrbitFile, TLEOrbit
from mgeo_attitude.settings.errors import InvalidValue
from sgp4 import exporter, omm
from sgp4.api import Satrec

from ..scenario.test_orbit import ISS_1, ISS_2, VANGUARD_1, with_checksum

REFERENCE = Path(__file__).parents[1] / "reference"
OMM, TLE = REFERENCE / "cosmos-2584.omm", REFERENCE / "iss-2022-05-08.tle"
EPOCH = datetime(2026, 7, 21, 10, tzinfo=UTC)
ISS_EPOCH = datetime(2008, 9, 20, 12, 40, tzinfo=UTC)
TIMES = np.arange(0.0, 6001.0, 60.0)

FIELDS = {
    key.strip(): value.strip()
    for key, _, value in (line.partition("=") for line in OMM.read_text().splitlines()[1:])
    if key
}


def format_kvn(*messages: dict[str, str]) -> str:
    return "".join(
        "CCSDS_OMM_VERS = 2.0\n" + "".join(f"{k} = {v}\n" for k, v in fields.items())
        for fields in messages
    )


def parse_number(text: str) -> str | float:
    """Return a text as a JSON number if possible, and else unchanged."""
    try:
        return float(text) if "." in text or "E" in text else int(text)
    except ValueError:
        return text


NOTATIONS: dict[str, Callable[..., str]] = {
    "a.omm": format_kvn,
    "a.json": lambda *m: json.dumps([{k: parse_number(v) for k, v in each.items()} for each in m]),
}


def read_orbit(file: Path, epoch: datetime = EPOCH, **keys: Any) -> Any:
    return OrbitFile(file=str(file), **keys).prepare_for_run(epoch, 6000.0)


@pytest.mark.parametrize(
    ("name", "epoch"),
    [
        ("cosmos-2584.omm", EPOCH),
        ("vanguard-1.omm.csv", datetime(2020, 10, 13, 5, tzinfo=UTC)),
        ("vanguard-1.omm.xml", datetime(2020, 10, 13, 5, tzinfo=UTC)),
    ],
)
def test_message_is_propagated_like_package_sgp4(name: str, epoch: datetime) -> None:
    path, satellite = REFERENCE / name, Satrec()
    with path.open() as file:
        fields = {
            ".omm": lambda: FIELDS,
            ".csv": lambda: next(omm.parse_csv(file)),
            ".xml": lambda: next(omm.parse_xml(file)),
        }[path.suffix]()
    omm.initialize(satellite, fields)
    expected, motion = compute_gcrs_states(satellite, compute_julian_dates(epoch, TIMES))
    orbit = read_orbit(path, epoch)
    position, velocity = orbit.propagate(epoch, TIMES)
    assert np.abs(position - expected).max() < 1e-6
    assert np.abs(velocity - motion).max() < 1e-9
    assert orbit.period == pytest.approx(86400.0 / float(fields["MEAN_MOTION"]), rel=1e-12)
    identity = (fields[key] for key in ("OBJECT_NAME", "OBJECT_ID", "NORAD_CAT_ID"))
    assert orbit.source == f"{name}, {' '.join(identity)}"


def test_message_and_lines_of_same_elements_give_same_orbit(tmp_path: Path) -> None:
    """The epoch in lines is rounded to 0.4 ms, or 3 m."""
    lines = TLEOrbit(line1=ISS_1, line2=ISS_2)
    fields = exporter.export_omm(Satrec.twoline2rv(ISS_1, ISS_2), "ISS (ZARYA)")
    (tmp_path / "iss.omm").write_text(format_kvn(fields))
    orbit = read_orbit(tmp_path / "iss.omm", ISS_EPOCH)
    both = [each.propagate(ISS_EPOCH, TIMES)[0] for each in (orbit, lines)]
    assert np.linalg.norm(both[0] - both[1], axis=1).max() < 5.0


@pytest.mark.parametrize("name", NOTATIONS)
def test_object_is_selected_in_each_notation(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    expected = read_orbit(OMM)
    other = FIELDS | {"NORAD_CAT_ID": "799501234", "OBJECT_NAME": "NEW", "OBJECT_ID": "2026-123A"}
    path.write_text(NOTATIONS[name](other, FIELDS))
    for requested_object in ("63130", "cosmos 2584 (704k)"):
        orbit = read_orbit(path, object=requested_object)
        assert dataclasses.replace(orbit, source=expected.source) == expected
    assert " NEW " in read_orbit(path, object="799501234").source
    with pytest.raises(InvalidValue, match=r"object = '' matches 2 entries: .* of NEW .* COSMOS"):
        read_orbit(path)
    with pytest.raises(InvalidValue, match=r"object = 'ISS' matches 0 entries: .* of NEW .*COSMOS"):
        read_orbit(path, object="ISS")


def build_line_pair(number: str, day: str = "08264.51782528") -> str:
    line1, line2 = f"1 {number}{ISS_1[7:18]}{day}{ISS_1[32:]}", f"2 {number}{ISS_2[7:]}"
    return f"{with_checksum(line1)}\r\n{with_checksum(line2)}\r\n"


def test_element_set_is_selected_in_file_of_lines(tmp_path: Path) -> None:
    """The file has lines with names, Alpha-5 numbers, and several sets of one object."""
    path = tmp_path / "stations.txt"
    path.write_text(
        f"0 NEW\r\n{build_line_pair('T0001')}OLD (A)   \r\n"
        f"{build_line_pair('25544', '08250.00000000')}OLD (A)\r\n"
        f"{build_line_pair('25544')}{build_line_pair('00005')}",
        newline="",
    )
    for requested_object in ("T0001", "270001", "new"):
        assert read_orbit(path, ISS_EPOCH, object=requested_object).source.startswith(
            "stations.txt, NEW 1998-"
        )
    for requested_object in ("00005", "5"):
        assert (
            read_orbit(path, ISS_EPOCH, object=requested_object).source
            == "stations.txt, 1998-067A 5"
        )
    orbit = read_orbit(path, ISS_EPOCH, object="old (a)")
    assert (orbit.line1, orbit.line2) == (ISS_1, ISS_2)
    for requested_object in ("", "1998-067A"):
        with pytest.raises(InvalidValue, match=r"entries: expected the name or number of"):
            read_orbit(path, ISS_EPOCH, object=requested_object)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (format_kvn(FIELDS | {"REF_FRAME": "EME2000"}), "REF_FRAME = 'EME2000': expected TEME"),
        (
            format_kvn(FIELDS | {"MEAN_ELEMENT_THEORY": "DSST"}),
            "MEAN_ELEMENT_THEORY = 'DSST': expected",
        ),
        (
            format_kvn(FIELDS | {"MEAN_MOTION": "18"}),
            "MEAN_MOTION = 18.0: expected a perigee above the",
        ),
        ('[1, "MEAN_MOTION"]', "expected mean-elements messages (OMM)"),
        (f"{VANGUARD_1}\n{ISS_2}", "Object numbers in lines 1 and 2 do not match"),
        ("neither lines\nnor a message", "expected element sets (OMM, or two lines) or an orbit"),
    ],
)
def test_file_without_usable_elements_is_rejected(tmp_path: Path, text: str, expected: str) -> None:
    path = tmp_path / "a.txt"
    path.write_text(text)
    with pytest.raises(InvalidValue) as caught:
        read_orbit(path)
    assert str(caught.value).startswith(f"file = '{path}': ")
    assert expected in str(caught.value)


def test_satellite_that_decays_during_run_is_rejected() -> None:
    """Case 28350 of Vallado et al. 2006, Cosmos 2405 in its last days."""
    orbit = TLEOrbit(
        line1="1 28350U 04020A   06167.21788666  .16154492  76267-5  18678-3 0  8894",
        line2="2 28350  64.9977 345.6130 0024870 260.7578  99.9590 16.47856722116490",
    )
    early = datetime(2006, 6, 16, 5, 13, 45, tzinfo=UTC)
    radius = np.linalg.norm(orbit.prepare_for_run(early, 6000.0).propagate(early, TIMES)[0], axis=1)
    assert radius.min() > 6378136.3 + 100e3
    late = datetime(2006, 6, 17, 4, 30, tzinfo=UTC)
    with pytest.raises(
        InvalidValue, match=r"^line1 = .* at 2006-06-17T05:4[0-9:.]*Z, t = \d+ s, it"
    ):
        orbit.prepare_for_run(late, 6000.0)
    with pytest.raises(SGP4Error, match=r"^satellite 28350: SGP4 error \d at t = "):
        orbit.propagate(late, np.arange(0.0, 86400.0, 600.0))
