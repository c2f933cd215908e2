"""Simulate the cases of docs/validation/consistency.md and write its table and figure.

``python -m tests.benchmarks.consistency plans remedies map`` takes about ten minutes on two cores.
A case that is already in docs/consistency.jsonl is not simulated again.
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
PAGE, PICTURE = DOCS / "validation/consistency.md", DOCS / "images" / "consistency.svg"
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

MAX_PLOTTED_NEES = 30.0
#: Filter settings that the page compares; the results of the others are only in the data.
SHOWN = [name for name in ESTIMATORS if name not in ("Jacobians", "Jacobians, second order")]

Results = dict[str, dict[str, Any]]


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


def format_plans_table(results: Results) -> Iterator[str]:
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


def format_remedies_table(results: Results) -> Iterator[str]:
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


def get_nees(results: Results, name: str, quantity: str, value: float, label: str) -> float:
    return float(results[f"map/{name}/{quantity}/{value:g}/{label}"]["criteria"]["nees"][0])


def draw(results: Results) -> None:
    """Write the figure of the NEES over each initial uncertainty."""
    low, high = next(
        row["criteria"]["nees"][1:] for key, row in results.items() if key.startswith("map/")
    )
    with mpl.rc_context({"svg.hashsalt": "consistency", "font.size": 9}):
        figure = Figure(figsize=(9.0, 3.2), layout="constrained")
        panels = figure.subplots(1, len(UNCERTAINTIES), sharey=True)
        for panel, (quantity, values) in zip(panels, UNCERTAINTIES.items(), strict=True):
            panel.axhspan(low, high, color="0.88")
            for name, color in (("paper", "tab:blue"), ("cubesat_6u", "tab:orange")):
                for label, line in (("plain", "--"), (DEFAULT, "-")):
                    y = [get_nees(results, name, quantity, value, label) for value in values]
                    text = f"{name}, {'plain' if label == 'plain' else 'as shipped'}"
                    panel.plot(values, y, line, marker=".", color=color, label=text)
            panel.set(xscale="log", yscale="log", xlabel=f"initial {quantity}, 1σ per axis")
            panel.set_xticks(values, [f"{value:g}" for value in values])
            panel.minorticks_off()
        panels[0].set_ylabel("NEES per state, 2nd half of an orbit")
        panels[0].set_ylim(0.8, MAX_PLOTTED_NEES)
        panels[0].set_yticks([1, 2, 5, 10, 20], ["1", "2", "5", "10", "20"])
        panels[0].legend(fontsize=8)
        figure.savefig(PICTURE, metadata={"Date": None})


def main(groups: Sequence[str]) -> None:
    known = {row["key"] for row in read_results(RESULTS)}
    for case in (case for group in groups for case in GROUPS[group]()):
        if case.key not in known:
            add_result(RESULTS, run_case(case))
    results = {row["key"]: row for row in read_results(RESULTS)}
    print(*format_plans_table(results), sep="\n")
    write_table(PAGE, "remedies", "\n".join(format_remedies_table(results)))
    draw(results)


if __name__ == "__main__":
    main(sys.argv[1:])
