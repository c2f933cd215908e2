"""Simulate the cases of docs/consistency.md and write its table and picture.

    python -m tests.benchmarks.consistency plans remedies map    # about ten minutes of two cores

A case that docs/consistency.jsonl has already is not simulated again.
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

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from mgeo_attitude import Scenario
from mgeo_attitude.scenario.validity import OutsideValidity
from mgeo_calibration import FilterSettings, evaluate_consistency, simulate

from .cases import FORMER_CUBESAT, FORMER_PAPER
from .pages import DOCS, ROOT, add_result, read_results, write_table

RESULTS = DOCS / "consistency.jsonl"
PAGE, PICTURE = DOCS / "consistency.md", DOCS / "images" / "consistency.svg"
PLANS = json.loads((ROOT / "tests/calibration/simulation/plans.json").read_text(encoding="utf-8"))

SEED = 20250
PRESETS = {
    "paper": Scenario.from_toml(FORMER_PAPER),
    "cubesat_6u": Scenario.from_toml(FORMER_CUBESAT),
}
PLAIN = FilterSettings.build_textbook()
ESTIMATORS = {
    "plain": PLAIN,
    "Jacobians": dataclasses.replace(PLAIN, jacobians="estimate"),
    "Jacobians, reset": FilterSettings(second_order=False),
    "Jacobians, second order": FilterSettings(reset=False),
    "Jacobians, reset, second order": FilterSettings(),
}
LARGE = "paper, attitude 20 deg, misalignments 4 deg"
DEFAULT = "Jacobians, reset, second order"
#: Initial uncertainties of the map, 1-sigma per axis.
SWEEPS = {
    "attitude [deg]": (5.0, 10.0, 20.0, 30.0, 45.0),
    "misalignment [deg]": (0.5, 1.0, 2.0, 4.0, 8.0),
    "gyro bias [deg/s]": (0.003, 0.01, 0.03, 0.1),
}

HOPELESS = 30.0
#: Estimators that the page compares; the others are in the data.
SHOWN = [name for name in ESTIMATORS if name not in ("Jacobians", "Jacobians, second order")]

Results = dict[str, dict[str, Any]]


@dataclasses.dataclass(frozen=True)
class Case:
    """One simulation, and where it belongs."""

    key: str
    scenario: Scenario
    design: Sequence[float]
    estimator: FilterSettings
    n_runs: int


def plans() -> Iterator[Case]:
    """Every stored plan with the estimator that ships."""
    for name, scenario in PRESETS.items():
        for i, plan in enumerate(PLANS["scenarios"][name]):
            yield Case(f"plans/{name}/{i}", scenario, plan["design"], FilterSettings(), 200)


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


def plans_table(results: Results) -> Iterator[str]:
    yield "| scenario | t_end [s] | NEES | beyond 3σ | RMS / predicted | |"
    yield "| --- | ---: | ---: | ---: | --- | --- |"
    for name, plans in PLANS["scenarios"].items():
        for i in range(len(plans)):
            row = results[f"plans/{name}/{i}"]
            c = row["criteria"]
            failed = [k for k, (value, low, high) in c.items() if not low <= value <= high]
            ratios = " to ".join(
                f"{c[f'{e} rms / predicted'][0]:.2f}" for e in ("smallest", "largest")
            )
            yield (
                f"| {name} | {row['t_end']:.0f} | {c['nees'][0]:.3f} | "
                f"{c['beyond 3 sigma'][0]:.0f} | {ratios} | "
                f"{'fails: ' + ', '.join(failed) if failed else 'passes'} |"
            )


def remedies_table(results: Results) -> Iterator[str]:
    yield "| | " + " | ".join(f"{name} | RMS / predicted" for name in ("cubesat_6u", LARGE)) + " |"
    yield "| --- | ---: | ---: | ---: | ---: |"
    for label in SHOWN:
        cells = []
        for name in ("cubesat_6u", LARGE):
            row = results[f"remedies/{name}/{label}"]
            c = row["criteria"]
            cells += [
                f"{row['nees_first_300s']:.2f}, {c['nees'][0]:.2f}",
                f"{c['largest rms / predicted'][0]:.2f}",
            ]
        name = f"**{label}**" if label == DEFAULT else label
        yield f"| {name} | {' | '.join(cells)} |"


def nees(results: Results, name: str, what: str, value: float, label: str) -> float:
    return float(results[f"map/{name}/{what}/{value:g}/{label}"]["criteria"]["nees"][0])


def draw(results: Results) -> None:
    """NEES over every swept uncertainty, both scenarios and estimators."""
    low, high = next(
        row["criteria"]["nees"][1:] for key, row in results.items() if key.startswith("map/")
    )
    with mpl.rc_context({"svg.hashsalt": "consistency", "font.size": 9}):
        figure = Figure(figsize=(9.0, 3.2), layout="constrained")
        panels = figure.subplots(1, len(SWEEPS), sharey=True)
        for panel, (what, values) in zip(panels, SWEEPS.items(), strict=True):
            panel.axhspan(low, high, color="0.88")
            for name, color in (("paper", "tab:blue"), ("cubesat_6u", "tab:orange")):
                for label, line in (("plain", "--"), (DEFAULT, "-")):
                    y = [nees(results, name, what, value, label) for value in values]
                    text = f"{name}, {'plain' if label == 'plain' else 'as shipped'}"
                    panel.plot(values, y, line, marker=".", color=color, label=text)
            panel.set(xscale="log", yscale="log", xlabel=f"initial {what}, 1σ per axis")
            panel.set_xticks(values, [f"{value:g}" for value in values])
            panel.minorticks_off()
        panels[0].set_ylabel("NEES per state, 2nd half of an orbit")
        panels[0].set_ylim(0.8, HOPELESS)
        panels[0].set_yticks([1, 2, 5, 10, 20], ["1", "2", "5", "10", "20"])
        panels[0].legend(fontsize=8)
        figure.savefig(PICTURE, metadata={"Date": None})


def main(groups: Sequence[str]) -> None:
    known = {row["key"] for row in read_results(RESULTS)}
    for case in (case for group in groups for case in GROUPS[group]()):
        if case.key not in known:
            add_result(RESULTS, run(case))
    results = {row["key"]: row for row in read_results(RESULTS)}
    print(*plans_table(results), sep="\n")
    write_table(PAGE, "remedies", "\n".join(remedies_table(results)))
    draw(results)


if __name__ == "__main__":
    main(sys.argv[1:])
