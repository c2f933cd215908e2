"""Calibrations as files: JSON that reads back.

``scenario``, ``time_s``, ``quaternion``, ``rate_deg_s``, ``states``, ``covariance``, ``tests`` and
``rejected`` are the calibration. ``utc``, ``table``, ``uplink`` and ``verdict`` follow from them;
on reading they are computed again, and a file that says something else is refused.
"""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from mgeo.files.reading import entry, errors_of, parse_json, read_text
from mgeo_attitude._typing import Floats
from mgeo_attitude.calibration.calibration import Calibration
from mgeo_attitude.calibration.sensor_tests import SensorTest
from mgeo_attitude.fields import InvalidValue
from mgeo_attitude.plan.files import MOST_BYTES, check_same
from mgeo_attitude.scenario import Scenario
from mgeo_attitude.scenario.prior import check_covariance

FORMAT = "mgeo-attitude-calibration"
VERSION = 1

_ROUNDING = 1e-9
_TABLES: Any = list[dict]  # type: ignore[type-arg]
_ROWS: Any = list[list]  # type: ignore[type-arg]
_KINDS = {"str": str, "int": int, "float": float}


def to_json(calibration: Calibration) -> str:
    """The calibration as a JSON document; floats by repr, so that it reads back exactly."""
    return json.dumps(document(calibration), indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def document(calibration: Calibration) -> dict[str, Any]:
    """What `to_json` writes."""
    return {
        "format": FORMAT,
        "version": VERSION,
        **calibration.entries(),
        "tests": [vars(test) for test in calibration.tests],
        "rejected": [list(one) for one in calibration.rejected],
        **_consequences(calibration),
    }


def from_json(text: str) -> Calibration:
    """Inverse of `to_json`, without the history.

    Raises
    ------
    ValueError, TypeError
        If the text is no JSON, of another format or version, or a key is missing, unknown, of a bad
        value, or does not follow from the others; the message names the key.
    """
    table = parse_json(text)
    found = table.get("format") if isinstance(table, dict) else None
    if found != FORMAT:
        raise ValueError(f"format = {found!r:.80}: expected {FORMAT!r}")
    version = table.get("version")
    if version != VERSION or isinstance(version, bool):
        raise ValueError(f"version = {version!r:.80}: this package reads version {VERSION}")
    try:
        scenario = Scenario.from_dict(entry(table, "scenario", dict))
    except InvalidValue as error:
        raise error.under("scenario") from None
    calibration = _calibration(table, scenario)
    written = document(calibration)
    for key in table:
        if key not in written:
            raise InvalidValue(key, table[key], f"expected {', '.join(written)}")
    for key, expected in _consequences(calibration).items():
        check_same(key, entry(table, key, type(expected)), expected, "the estimate")
    return calibration


def read_json(path: Path | str) -> Calibration:
    """Read what `to_json` made of a calibration from a file.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        Naming the file and the key, see `from_json`.
    """
    text = read_text(path, MOST_BYTES)
    with errors_of(path):
        return from_json(text)


def _consequences(calibration: Calibration) -> dict[str, Any]:
    return {
        "utc": calibration.utc,
        "table": calibration.table().to_dict("records"),
        "uplink": calibration.uplink(),
        "verdict": calibration.verdict,
    }


def _calibration(table: dict[str, Any], scenario: Scenario) -> Calibration:
    from mgeo_attitude.filter.suite import Suite

    blocks = Suite(scenario.gyro, scenario.sensors).blocks
    n, states = 3 * len(blocks), entry(table, "states", dict)
    if list(states) != list(blocks[1:]):
        raise InvalidValue("states", list(states), f"expected {', '.join(blocks[1:])}")
    values = [_numbers(states, block, (3,), "states.") for block in blocks[1:]]
    covariance = _numbers(table, "covariance", (n, n))
    check_covariance(covariance, n)
    quaternion = _numbers(table, "quaternion", (4,))
    if abs(np.linalg.norm(quaternion) - 1.0) > _ROUNDING:
        raise InvalidValue("quaternion", quaternion.tolist(), "expected one of unit length")
    names = [sensor.name for sensor in scenario.sensors]
    tests = tuple(
        _test(row, f"tests[{i}].") for i, row in enumerate(entry(table, "tests", _TABLES))
    )
    rejected = tuple(
        _rejected(row, f"rejected[{i}]", names)
        for i, row in enumerate(entry(table, "rejected", _ROWS))
    )
    for i, test in enumerate(tests):
        if test.sensor not in names:
            raise InvalidValue(f"tests[{i}].sensor", test.sensor, f"expected one of {names}")
    return Calibration(
        scenario=scenario,
        time=float(entry(table, "time_s", float)),
        quaternion=quaternion,
        rate_deg_s=_numbers(table, "rate_deg_s", (3,)),
        states=np.concatenate([np.zeros(3), *values]),
        covariance=covariance,
        tests=tests,
        rejected=rejected,
    )


def _test(row: dict[str, Any], where: str) -> SensorTest:
    names = {field.name: _KINDS[str(field.type)] for field in fields(SensorTest)}
    for key in row:
        if key not in names:
            raise InvalidValue(f"{where}{key}", row[key], f"expected {', '.join(names)}")
    return SensorTest(**{name: kind(entry(row, name, kind, where)) for name, kind in names.items()})


def _rejected(row: list[Any], where: str, names: list[str]) -> tuple[float, str, float]:
    table = dict(zip(("time", "sensor", "chi_square"), row, strict=False))
    time, sensor, square = (
        entry(table, key, kind, f"{where}.")
        for key, kind in (("time", float), ("sensor", str), ("chi_square", float))
    )
    if len(row) > 3 or sensor not in names:
        raise InvalidValue(where, row, f"expected a time, one of {names}, and a chi-square")
    return float(time), sensor, float(square)


def _numbers(table: dict[str, Any], key: str, shape: tuple[int, ...], where: str = "") -> Floats:
    kind = list[float] if len(shape) == 1 else _ROWS
    rows = entry(table, key, kind, where)
    if len(shape) == 2:
        rows = [entry({str(i): row}, str(i), list[float], f"{key}.") for i, row in enumerate(rows)]
    if len(rows) != shape[0] or any(len(row) != shape[1] for row in rows if len(shape) == 2):
        raise ValueError(f"{where}{key}: expected {' x '.join(map(str, shape))} numbers")
    return np.array(rows, dtype=float)
