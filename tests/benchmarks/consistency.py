"""Simulate the cases of docs/validation/consistency.md.

``python -m tests.benchmarks.consistency plans remedies map`` takes about ten minutes on two cores.
A case that is already in docs/validation/data/consistency.jsonl is not simulated again.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import time
import warnings
from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import numpy as np
from mgeo_attitude import Scenario
from mgeo_attitude.scenario.validity import OutsideValidity
from mgeo_calibration import FilterSettings, evaluate_consistency, simulate

from .cases import FORMER_CUBESAT, FORMER_PAPER
from .pages import ROOT, VALIDATION_DATA, add_result, read_results

RESULTS = VALIDATION_DATA / "consistency.jsonl"
PLANS = json.loads((ROOT / "tests/calibration/simulation/plans.json").read_text(encoding="utf-8"))

SEED = 20250
PRESETS = {
    "paper": Scenario.from_toml(FORMER_PAPER),
    "cubesat_6u": Scenario.from_toml(FORMER_CUBESAT),
}
TEXTBOOK = FilterSettings.build_textbook()
ESTIMATORS = {
    "plain": TEXTBOOK,
    "Jacobians": dataclasses.replace(TEXTBOOK, jacobians="estimate"),
    "Jacobians, reset": FilterSettings(second_order=False),
    "Jacobians, second order": FilterSettings(reset=False),
    "Jacobians, reset, second order": FilterSettings(),
}
LARGE = "paper, attitude 20 deg, misalignments 4 deg"
DEFAULT = "Jacobians, reset, second order"
#: Initial uncertainties that are varied one at a time, 1-sigma per axis.
UNCERTAINTIES = {
    "attitude [deg]": (5.0, 10.0, 20.0, 30.0, 45.0),
    "misalignment [deg]": (0.5, 1.0, 2.0, 4.0, 8.0),
    "gyro bias [deg/s]": (0.003, 0.01, 0.03, 0.1),
}


@dataclasses.dataclass(frozen=True)
class Case:
    """One Monte Carlo simulation with the key of its result."""

    key: str
    scenario: Scenario
    design: Sequence[float]
    estimator: FilterSettings
    n_runs: int


def list_plan_cases() -> Iterator[Case]:
    """Yield one case for each stored plan, with the default filter."""
    for name, scenario in PRESETS.items():
        for i, plan in enumerate(PLANS["scenarios"][name]):
            yield Case(f"plans/{name}/{i}", scenario, plan["design"], FilterSettings(), 200)


def list_remedy_cases() -> Iterator[Case]:
    """Yield cases with all filter settings, for each preset and larger errors, over one orbit."""
    large = replace_uncertainties(
        PRESETS["paper"], {"attitude [deg]": 20.0, "misalignment [deg]": 4.0}
    )
    cases = {"cubesat_6u": PRESETS["cubesat_6u"], LARGE: large, "paper": PRESETS["paper"]}
    for name, scenario in cases.items():
        design = PLANS["scenarios"][name.partition(",")[0]][2]["design"]
        for label, estimator in ESTIMATORS.items():
            yield Case(
                f"remedies/{name}/{label}", shorten_to_one_orbit(scenario), design, estimator, 200
            )


def list_map_cases() -> Iterator[Case]:
    """Yield cases with one changed initial uncertainty each, over one orbit."""
    for label, name in product((DEFAULT, "plain"), PRESETS):
        scenario, design = (
            shorten_to_one_orbit(PRESETS[name]),
            PLANS["scenarios"][name][2]["design"],
        )
        for quantity, values in UNCERTAINTIES.items():
            for value in values:
                changed = replace_uncertainties(scenario, {quantity: value})
                key = f"map/{name}/{quantity}/{value:g}/{label}"
                yield Case(key, changed, design, ESTIMATORS[label], 100)


GROUPS = {"plans": list_plan_cases, "remedies": list_remedy_cases, "map": list_map_cases}


def shorten_to_one_orbit(scenario: Scenario) -> Scenario:
    return dataclasses.replace(scenario, duration=5992.0)


def replace_uncertainties(scenario: Scenario, values: dict[str, float]) -> Scenario:
    """Return the scenario with other initial uncertainties, keyed as in `UNCERTAINTIES`."""
    initial, gyro, sensors = scenario.initial, scenario.gyro, scenario.sensors
    for quantity, value in values.items():
        if quantity == "attitude [deg]":
            initial = dataclasses.replace(initial, attitude_deg=value)
        elif quantity == "gyro bias [deg/s]":
            gyro = dataclasses.replace(gyro, initial_bias_deg_s=value)
        else:
            sensors = tuple(dataclasses.replace(s, initial_misalignment_deg=value) for s in sensors)
    return dataclasses.replace(scenario, initial=initial, gyro=gyro, sensors=sensors)


def run_case(case: Case) -> dict[str, Any]:
    """Simulate a case and return the values that the tables need, as a dict that becomes JSON."""
    start = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OutsideValidity)
        result = simulate(
            case.scenario, case.design, case.n_runs, SEED, filter_settings=case.estimator
        )
    seconds = time.perf_counter() - start
    report = evaluate_consistency(result)
    first = (result.times > 0.0) & (result.times <= 300.0)
    return {
        "key": case.key,
        "n_runs": case.n_runs,
        "seconds": round(seconds, 1),
        "t_end": result.t_end,
        "nees_first_300s": float(result.nees[:, first].mean() / result.n_states),
        "passed": bool(report["passed"].all()),
        "criteria": report[["value", "low", "high"]].T.to_dict("list"),
        "ratio_at_t_end": [
            float(extreme) for extreme in np.quantile(result.build_table()["ratio"], (0.0, 1.0))
        ],
    }


def main(groups: Sequence[str]) -> None:
    known = {row["key"] for row in read_results(RESULTS)}
    for case in (case for group in groups for case in GROUPS[group]()):
        if case.key not in known:
            add_result(RESULTS, run_case(case))


if __name__ == "__main__":
    main(sys.argv[1:])
