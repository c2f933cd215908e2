"""Simulate flights of plans with Basilisk, calibrate, and write the table and the figure of
docs/validation/basilisk.md.

``OMP_NUM_THREADS=1 python -m tests.benchmarks.basilisk 50`` simulates 50 flights of each plan. A
flight that is already in docs/basilisk.jsonl is not repeated. Flights of all plans alternate, so
that all plans have the same number of flights whenever the script is stopped.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from itertools import product
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from mgeo_attitude import AttitudeManeuverProblem, run_reference_filter
from mgeo_attitude.geometry.rotation import rotation_matrix, rotation_vector
from mgeo_calibration.calibration.calibrate import calibrate
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.simulators.basilisk.telemetry import simulate_telemetry
from mgeo_calibration.telemetry.telemetry import Truth
from scipy.stats import chi2, norm

from ..three import three
from .pages import DOCS, ROOT, add_result, read_results, write_table

RESULTS = DOCS / "basilisk.jsonl"
PAGE, PICTURE = DOCS / "validation/basilisk.md", DOCS / "images" / "basilisk.svg"
PLANS = json.loads(
    (ROOT / "tests/calibration/simulators/basilisk/plans.json").read_text(encoding="utf-8")
)["scenarios"]
FIRST_SEED = 9000
ENDS = ("at t_end", "at the end")
#: Probabilities of the lower and the upper statistical bound.
BOUNDS = (0.005, 0.995)

Rows = list[dict[str, Any]]


@cache
def build_problem(name: str) -> AttitudeManeuverProblem:
    return AttitudeManeuverProblem(three(name))


@cache
def predict_sigma(name: str, number: int) -> dict[str, Any]:
    """Return t_end of a plan and the 1-sigma of all states by the linear covariance, at t_end and
    at the end.
    """
    model, plan = build_problem(name).model, PLANS[name][number]
    full_duration_model = dataclasses.replace(model, window_steps=model.n_steps + 1)
    history, full_history = (
        run_reference_filter(each_model, plan["design"])
        for each_model in (model, full_duration_model)
    )
    return {
        "t_end": history.t_end,
        "at t_end": history.sigma[-1],
        "at the end": full_history.sigma[-1],
    }


def compute_errors(calibration: Calibration, truth: Truth) -> np.ndarray:
    """Return truth minus estimate at the last sample; errors of rotations are rotation vectors."""
    suite, e = calibration.suite, truth.states[-1] - calibration.states
    assert calibration.history is not None
    for first in suite.rotation_indices[1:]:
        block = slice(first, first + 3)
        rotation_error = rotation_matrix(calibration.states[block]).T @ rotation_matrix(
            truth.states[-1, block]
        )
        e[block] = rotation_vector(rotation_error)
    e[:3] = rotation_vector(calibration.history.smoothed_attitude[-1] @ truth.attitude[-1].T)
    return e


def run_case(case: tuple[str, int, int]) -> list[dict[str, Any]]:
    """Simulate one flight of a plan, and calibrate with its telemetry until t_end and with all of
    its telemetry.
    """
    name, number, seed = case
    problem, predicted, start = (
        build_problem(name),
        predict_sigma(name, number),
        time.perf_counter(),
    )
    telemetry = simulate_telemetry(
        problem.scenario, PLANS[name][number]["design"], seed, environment=problem.environment
    )
    flight_seconds, rows = time.perf_counter() - start, []
    for end_name, end in (
        ("at t_end", predicted["t_end"]),
        ("at the end", problem.scenario.duration),
    ):
        truncated, start = telemetry.truncate(end), time.perf_counter()
        row: dict[str, Any] = {
            "key": [name, number, seed, end_name],
            "t": end,
            "flight s": flight_seconds,
        }
        try:
            calibration = calibrate(problem.scenario, truncated)
        except ValueError as error:
            rows.append(row | {"refused": str(error)})
            continue
        assert truncated.truth is not None
        e, P = compute_errors(calibration, truncated.truth), calibration.covariance
        rows.append(
            row
            | {
                "calibration s": time.perf_counter() - start,
                "errors": e.tolist(),
                "sigma": np.sqrt(np.diag(P)).tolist(),
                "predicted": predicted[end_name].tolist(),
                "nees": float(e @ np.linalg.solve(P, e)),
                "nis": {test.sensor: test.nis for test in calibration.tests},
                "consistent": bool(calibration.is_consistent),
                "rejected": len(calibration.outliers),
            }
        )
    return rows


def select_rows(rows: Rows, name: str, end_name: str, number: int | None = None) -> Rows:
    """Return the results of a preset until one of `ENDS`, for one plan or for all plans."""
    return [
        row
        for row in rows
        if (row["key"][0], row["key"][3]) == (name, end_name) and number in (None, row["key"][1])
    ]


def get_column(rows: Rows, key: str) -> np.ndarray:
    return np.array([row[key] for row in rows])


def compute_bounds(n: int) -> tuple[float, float]:
    """Return the 99 % bounds of the mean of n squared standard normal values."""
    low, high = chi2.ppf(BOUNDS, n) / n
    return float(low), float(high)


def format_plans_table(rows: Rows) -> Iterator[str]:
    yield (
        "| scenario | until [s] | flights | NEES per state (99 % bounds) | errors beyond 3σ "
        "(expected) | RMS error / 1σ | 1σ / predicted 1σ | consistent |"
    )
    yield "| --- | ---: | ---: | --- | --- | ---: | --- | ---: |"
    for name, plans in PLANS.items():
        for number in range(len(plans)):
            for end_name in ENDS:
                selected = select_rows(rows, name, end_name, number)
                z = get_column(selected, "errors") / get_column(selected, "sigma")
                nees = get_column(selected, "nees").sum() / z.size
                low, high = compute_bounds(z.size)
                ratio = np.median(
                    get_column(selected, "sigma") / get_column(selected, "predicted"), axis=0
                )
                yield (
                    f"| {name} | {selected[0]['t']:.0f} | {len(selected)} | {nees:.3f} "
                    f"({low:.3f} to {high:.3f}){'' if low < nees < high else ' **out**'} | "
                    f"{(np.abs(z) > 3).sum()} ({2 * norm.sf(3) * z.size:.1f}) | "
                    f"{np.sqrt((z**2).mean()):.3f} | {ratio.min():.2f} to {ratio.max():.2f} | "
                    f"{sum(row['consistent'] for row in selected)} of {len(selected)} |"
                )


def format_blocks_table(rows: Rows) -> Iterator[str]:
    yield "| | " + " | ".join(f"{name}, {end_name}" for name in PLANS for end_name in ENDS) + " |"
    yield "| --- |" + " ---: |" * (len(PLANS) * len(ENDS))
    for i, block in enumerate(build_problem("paper").model.suite.blocks):
        cells = []
        for name in PLANS:
            for end_name in ENDS:
                selected, part = select_rows(rows, name, end_name), slice(3 * i, 3 * i + 3)
                e = get_column(selected, "errors")[:, part]
                ratios = [
                    np.sqrt(((e / get_column(selected, key)[:, part]) ** 2).mean())
                    for key in ("sigma", "predicted")
                ]
                cells.append(f"{ratios[0]:.2f}, {ratios[1]:.2f}")
        yield f"| {block} | {' | '.join(cells)} |"
    n = 3 * len(select_rows(rows, "paper", ENDS[0]))
    low, high = np.sqrt(compute_bounds(n))
    yield (
        f"| *99 % bounds, {n} errors* | " + " | ".join([f"*{low:.2f} to {high:.2f}*"] * 4) + " |"
    )


def draw(rows: Rows) -> None:
    """Write the figure of all errors over their estimated 1-sigma, by state block."""
    blocks = build_problem("paper").model.suite.blocks
    with mpl.rc_context({"svg.hashsalt": "basilisk", "font.size": 9}):
        figure = Figure(figsize=(9.0, 3.2), layout="constrained")
        panels = figure.subplots(1, len(PLANS), sharey=True)
        for panel, name in zip(panels, PLANS, strict=True):
            selected = select_rows(rows, name, ENDS[1])
            z = get_column(selected, "errors") / get_column(selected, "sigma")
            panel.axhspan(-3, 3, color="0.92")
            panel.axhspan(-1, 1, color="0.84")
            scatter = np.linspace(-0.3, 0.3, len(z))
            for i in range(len(blocks)):
                for axis, color in enumerate(("tab:red", "tab:green", "tab:blue")):
                    positions, values = i + scatter, z[:, 3 * i + axis]
                    panel.plot(positions, values, ".", color=color, ms=3, label="xyz"[axis])
            panel.set_xticks(range(len(blocks)), blocks, rotation=20, ha="right")
            panel.set_title(f"{name}, {len(z)} flights of two orbits")
        panels[0].set_ylabel("error / estimated 1σ")
        handles, labels = panels[0].get_legend_handles_labels()
        panels[0].legend(handles[:3], labels[:3], ncols=3, fontsize=8)
        figure.savefig(PICTURE, metadata={"Date": None})


def main(n_flights: int) -> None:
    stored = {tuple(row["key"][:3]) for row in read_results(RESULTS)}
    cases = [
        (name, number, FIRST_SEED + 1000 * number + flight)  # The seeds of pooled plans differ.
        for flight, number, name in product(range(n_flights), range(4), PLANS)
    ]
    with ProcessPoolExecutor(2) as pool:
        for rows in pool.map(run_case, [case for case in cases if case not in stored]):
            for row in rows:
                add_result(RESULTS, row)
    rows = [row for row in read_results(RESULTS) if "errors" in row]
    print(*format_plans_table(rows), sep="\n")
    write_table(PAGE, "blocks", "\n".join(format_blocks_table(rows)))
    draw(rows)


if __name__ == "__main__":
    main(int(sys.argv[1]))
