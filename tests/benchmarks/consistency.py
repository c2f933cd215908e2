"""Simulates the cases of docs/consistency.md, and writes its tables and its picture.

    python -m tests.benchmarks.consistency plans remedies map    # about ten minutes of two cores
    python -m tests.benchmarks.consistency_document

A case that is in docs/consistency.jsonl already is not simulated again.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import time
import warnings
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from mgeo_attitude import Scenario
from mgeo_attitude.scenario.validity import OutsideValidity
from mgeo_calibration import Estimator, consistency, simulate

from .cases import FORMER_CUBESAT, FORMER_PAPER

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "docs" / "consistency.jsonl"
PLANS = json.loads((ROOT / "tests/calibration/simulation/plans.json").read_text(encoding="utf-8"))

SEED = 20250
PRESETS = {
    "paper": Scenario.from_toml(FORMER_PAPER),
    "cubesat_6u": Scenario.from_toml(FORMER_CUBESAT),
}
PLAIN = Estimator.plain()
ESTIMATORS = {
    "plain": PLAIN,
    "Jacobians": dataclasses.replace(PLAIN, jacobians="estimate"),
    "Jacobians, reset": Estimator(second_order=False),
    "Jacobians, second order": Estimator(reset=False),
    "Jacobians, reset, second order": Estimator(),
}
LARGE = "paper, attitude 20 deg, misalignments 4 deg"
DEFAULT = "Jacobians, reset, second order"
#: Initial uncertainties of the map, 1-sigma per axis.
SWEEPS = {
    "attitude [deg]": (5.0, 10.0, 20.0, 30.0, 45.0),
    "misalignment [deg]": (0.5, 1.0, 2.0, 4.0, 8.0),
    "gyro bias [deg/s]": (0.003, 0.01, 0.03, 0.1),
}


@dataclasses.dataclass(frozen=True)
class Case:
    """One simulation, and where it belongs."""

    key: str
    scenario: Scenario
    design: Sequence[float]
    estimator: Estimator
    n_runs: int


def plans() -> Iterator[Case]:
    """Every stored plan with the estimator that ships."""
    for name, scenario in PRESETS.items():
        for i, plan in enumerate(PLANS["scenarios"][name]):
            yield Case(f"plans/{name}/{i}", scenario, plan["design"], Estimator(), 200)


def remedies() -> Iterator[Case]:
    """Every estimator on one plan of each preset and with larger errors; one orbit."""
    large = with_uncertainty(PRESETS["paper"], {"attitude [deg]": 20.0, "misalignment [deg]": 4.0})
    cases = {"cubesat_6u": PRESETS["cubesat_6u"], LARGE: large, "paper": PRESETS["paper"]}
    for name, scenario in cases.items():
        design = PLANS["scenarios"][name.partition(",")[0]][2]["design"]
        for label, estimator in ESTIMATORS.items():
            yield Case(f"remedies/{name}/{label}", one_orbit(scenario), design, estimator, 200)


def sweeps() -> Iterator[Case]:
    """One uncertainty at a time; one orbit, 100 runs."""
    for label, name in product((DEFAULT, "plain"), PRESETS):
        scenario, design = one_orbit(PRESETS[name]), PLANS["scenarios"][name][2]["design"]
        for what, values in SWEEPS.items():
            for value in values:
                varied = with_uncertainty(scenario, {what: value})
                key = f"map/{name}/{what}/{value:g}/{label}"
                yield Case(key, varied, design, ESTIMATORS[label], 100)


GROUPS = {"plans": plans, "remedies": remedies, "map": sweeps}


def one_orbit(scenario: Scenario) -> Scenario:
    """The scenario cut to its first orbital period."""
    return dataclasses.replace(scenario, duration=5992.0)


def with_uncertainty(scenario: Scenario, values: dict[str, float]) -> Scenario:
    """A scenario with other initial uncertainties, named as in `SWEEPS`."""
    initial, gyro, sensors = scenario.initial, scenario.gyro, scenario.sensors
    for what, value in values.items():
        if what == "attitude [deg]":
            initial = dataclasses.replace(initial, attitude_deg=value)
        elif what == "gyro bias [deg/s]":
            gyro = dataclasses.replace(gyro, initial_bias_deg_s=value)
        else:
            sensors = tuple(dataclasses.replace(s, initial_misalignment_deg=value) for s in sensors)
    return dataclasses.replace(scenario, initial=initial, gyro=gyro, sensors=sensors)


def run(case: Case) -> dict[str, Any]:
    """Simulate a case; what the tables need of it."""
    start = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OutsideValidity)
        result = simulate(case.scenario, case.design, case.n_runs, SEED, estimator=case.estimator)
    seconds = time.perf_counter() - start
    report = consistency(result)
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
            float(extreme) for extreme in np.quantile(result.table()["ratio"], (0.0, 1.0))
        ],
    }


def main(groups: Sequence[str]) -> None:
    known = {row["key"] for row in stored()}
    for case in (case for group in groups for case in GROUPS[group]()):
        if case.key not in known:
            line = json.dumps(run(case))
            sys.stdout.write(f"{line}\n")
            with RESULTS.open("a", encoding="utf-8") as file:
                file.write(f"{line}\n")


def stored() -> list[dict[str, Any]]:
    """Results so far."""
    if not RESULTS.exists():
        return []
    return [json.loads(line) for line in RESULTS.read_text(encoding="utf-8").splitlines()]


if __name__ == "__main__":
    main(sys.argv[1:])
