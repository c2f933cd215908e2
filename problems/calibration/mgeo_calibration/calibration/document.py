"""JSON documents of calibrations: conversion, reading and writing.

The keys ``scenario``, ``time_s``, ``quaternion``, ``rate_deg_s``, ``states``, ``covariance``,
``sensor_tests``, ``prior_tests``, ``model_tests``, ``data_faults``, ``notes`` and ``outliers``
define the calibration. The other keys are derived from them and ignored on reading.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

import numpy as np
from mgeo_attitude.plan.documents import DocumentFormat, read_document, serialize
from mgeo_attitude.scenario.prior import read_prior
from mgeo_attitude.scenario.scenario import Scenario

from mgeo.plugins.review import build_records
from mgeo.validation.entries import get_entry
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.consistency_tests import PriorTest, SensorTest
from mgeo_calibration.calibration.model_tests import ModelTest

T = TypeVar("T", SensorTest, PriorTest, ModelTest)

_TABLES: Any = list[dict]  # type: ignore[type-arg]
_ROWS: Any = list[list]  # type: ignore[type-arg]
_ESTIMATES = {"quaternion": list, "rate_deg_s": list, "states": dict, "covariance": _ROWS}


def to_json(calibration: Calibration) -> str:
    """Return a calibration as JSON text in which floats keep full precision."""
    return serialize(build_document(calibration))


def build_document(calibration: Calibration) -> dict[str, Any]:
    """Return a calibration as a JSON-serializable dict."""
    return _FORM.build_document(calibration)


def from_json(text: str) -> Calibration:
    """Return the calibration that the JSON text of a calibration file describes. It has no attitude
    history, because files do not contain one.

    Raises
    ------
    ValueError
        With the invalid key, or if the text is not a calibration document.
    """
    return _FORM.parse(text)


def read_json(path: Path | str) -> Calibration:
    """Return the calibration in a JSON file. It has no attitude history, because files do not
    contain one.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        With the file and the invalid key; see `from_json`.
    """
    return read_document(path, from_json)


def _collect_keys(calibration: Calibration) -> dict[str, Any]:
    return {
        **calibration.to_entries(),
        "sensor_tests": [vars(test) for test in calibration.tests],
        "prior_tests": [vars(test) for test in calibration.prior_tests],
        "model_tests": [vars(test) for test in calibration.model_tests],
        "data_faults": list(calibration.data_faults),
        "notes": list(calibration.notes),
        "outliers": calibration.build_outlier_table().to_dict("records"),
    }


def summarize(calibration: Calibration) -> dict[str, Any]:
    """Return the derived keys of a calibration document: the verdict, requirements,
    parameters and tests.
    """
    return {
        "conclusion": calibration.conclusion,
        "is_consistent": calibration.is_consistent,
        "failures": [vars(failure) for failure in calibration.failures],
        "utc": calibration.utc,
        "attitude_1sigma_deg": calibration.attitude_sigma_deg,
        "requirements": build_records(calibration.build_requirement_table()),
        "parameters": calibration.build_parameters(),
        "corrections": calibration.compute_corrections(),
        "tests": calibration.build_test_table().reset_index().to_dict("records"),
        "not_calibrated": calibration.list_uncalibrated(),
    }


def _build_calibration(table: Mapping[str, Any], scenario: Scenario) -> Calibration:
    for key, kind in _ESTIMATES.items():
        get_entry(table, key, kind)
    prior = read_prior(table, scenario.suite)
    return Calibration(
        scenario=scenario,
        time=float(get_entry(table, "time_s", float)),
        quaternion=np.array(prior.quaternion),
        rate_deg_s=np.array(prior.rate_deg_s),
        states=prior.estimates,
        covariance=np.array(prior.covariance),
        tests=_read_tests(SensorTest, table, "sensor_tests"),
        outliers=tuple(
            (float(row["time_s"]), str(row["sensor"]), float(row["chi_square"]))
            for row in get_entry(table, "outliers", _TABLES)
        ),
        prior_tests=_read_tests(PriorTest, table, "prior_tests"),
        model_tests=_read_tests(ModelTest, table, "model_tests"),
        data_faults=tuple(get_entry(table, "data_faults", list[str])),
        notes=tuple(get_entry(table, "notes", list[str])),
    )


def _read_tests(test_class: type[T], table: Mapping[str, Any], key: str) -> tuple[T, ...]:
    types = get_type_hints(test_class)
    return tuple(
        test_class(
            **{name: to(get_entry(row, name, to, f"{key}[{i}].")) for name, to in types.items()}
        )
        for i, row in enumerate(get_entry(table, key, _TABLES))
    )


_FORM = DocumentFormat(
    "mgeo-attitude-calibration",
    2,
    defining_entries=_collect_keys,
    build=_build_calibration,
    derived_entries=summarize,
)
