"""Calibrations as files: JSON that reads back.

``scenario``, ``time_s``, ``quaternion``, ``rate_deg_s``, ``states``, ``covariance``, ``tests``,
``prior_tests``, ``model_tests``, ``causes``, ``notes`` and ``rejected`` are the calibration; a file
without ``prior_tests``, ``model_tests``, ``causes`` or ``notes`` is of an earlier version. ``utc``,
``table``, ``uplink`` and ``conclusion`` follow from them; on reading they are ignored and computed
again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from mgeo_attitude.plan.documents import Form, read_document, written
from mgeo_attitude.scenario.prior import prior_of
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.settings.errors import InvalidValue

from mgeo.validation.tables import entry
from mgeo_calibration.calibration.agreement import PriorTest, SensorTest
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.model_tests import ModelTest

T = TypeVar("T", SensorTest, PriorTest, ModelTest)

_TABLES: Any = list[dict]  # type: ignore[type-arg]
_ROWS: Any = list[list]  # type: ignore[type-arg]
_ESTIMATES: dict[str, Any] = {
    "quaternion": list,
    "rate_deg_s": list,
    "states": dict,
    "covariance": _ROWS,
}
_KINDS = {"str": str, "int": int, "float": float, "bool": bool}


def to_json(calibration: Calibration) -> str:
    """The calibration as a JSON document; floats by repr, so that it reads back exactly."""
    return written(document(calibration))


def document(calibration: Calibration) -> dict[str, Any]:
    """What `to_json` writes."""
    return _FORM.document(calibration)


def from_json(text: str) -> Calibration:
    """Inverse of `to_json`, without the history; raises as `Form.read`."""
    return _FORM.read(text)


def read_json(path: Path | str) -> Calibration:
    """Read what `to_json` made of a calibration from a file.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        Naming the file and the key, see `from_json`.
    """
    return read_document(path, from_json)


def _keys(calibration: Calibration) -> dict[str, Any]:
    return {
        **calibration.entries(),
        "tests": [vars(test) for test in calibration.tests],
        "prior_tests": [vars(test) for test in calibration.prior_tests],
        "model_tests": [vars(test) for test in calibration.model_tests],
        "causes": list(calibration.causes),
        "notes": list(calibration.notes),
        "rejected": [list(one) for one in calibration.rejected],
    }


def _consequences(calibration: Calibration) -> dict[str, Any]:
    return {
        "utc": calibration.utc,
        "table": calibration.table().to_dict("records"),
        "uplink": calibration.uplink(),
        "conclusion": calibration.conclusion,
    }


def _calibration(table: Mapping[str, Any], scenario: Scenario) -> Calibration:
    for key, kind in _ESTIMATES.items():
        entry(table, key, kind)
    prior = prior_of(table, scenario.suite)
    names = [sensor.name for sensor in scenario.sensors]
    tests = _tests(SensorTest, table, "tests")
    given = {"prior_tests": [], "model_tests": [], "causes": [], "notes": [], **table}
    prior_tests = _tests(PriorTest, given, "prior_tests")
    model_tests = _tests(ModelTest, given, "model_tests")
    notes = tuple(entry(given, "notes", list[str]))
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
        quaternion=np.array(prior.quaternion),
        rate_deg_s=np.array(prior.rate_deg_s),
        states=prior.estimates,
        covariance=np.array(prior.covariance),
        tests=tests,
        rejected=rejected,
        prior_tests=prior_tests,
        model_tests=model_tests,
        causes=tuple(entry(given, "causes", list[str])),
        notes=notes,
    )


def _tests(kind: type[T], table: Mapping[str, Any], key: str) -> tuple[T, ...]:
    rows = enumerate(entry(table, key, _TABLES))
    return tuple(_test(kind, row, f"{key}[{i}].") for i, row in rows)


def _test(kind: type[T], row: dict[str, Any], where: str) -> T:
    names = {field.name: _KINDS[str(field.type)] for field in fields(kind)}
    if kind is ModelTest:
        row = {"rival": "", **row}
    for key in row:
        if key not in names:
            raise InvalidValue(f"{where}{key}", row[key], f"expected {', '.join(names)}")
    return kind(**{name: to(entry(row, name, to, where)) for name, to in names.items()})


def _rejected(row: list[Any], where: str, names: list[str]) -> tuple[float, str, float]:
    table = dict(zip(("time", "sensor", "chi_square"), row, strict=False))
    time, sensor, square = (
        entry(table, key, kind, f"{where}.")
        for key, kind in (("time", float), ("sensor", str), ("chi_square", float))
    )
    if len(row) > 3 or sensor not in names:
        raise InvalidValue(where, row, f"expected a time, one of {names}, and a chi-square")
    return float(time), sensor, float(square)


_FORM = Form(
    "mgeo-attitude-calibration",
    2,
    keys=_keys,
    made=_calibration,
    consequences=_consequences,
)
