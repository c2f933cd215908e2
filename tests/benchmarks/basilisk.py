"""Fly plans by Basilisk, calibrate, and write the table and the picture of docs/basilisk.md.

    OMP_NUM_THREADS=1 python -m tests.benchmarks.basilisk 50  # flights of each plan

A flight that docs/basilisk.jsonl has already is not repeated. Flights of all plans take turns, so
that the file is balanced whenever the script is stopped.
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
PAGE, PICTURE = DOCS / "basilisk.md", DOCS / "images" / "basilisk.svg"
PLANS = json.loads(
    (ROOT / "tests/calibration/simulators/basilisk/plans.json").read_text(encoding="utf-8")
)["scenarios"]
FIRST_SEED = 9000
WHEN = ("at t_end", "at the end")
#: Means of chi-squares outside of these are too far off to be chance, with 99 %.
BOUNDS = (0.005, 0.995)

Rows = list[dict[str, Any]]


@cache
def problem(name: str) -> AttitudeManeuverProblem:
    return AttitudeManeuverProblem(three(name))


@cache
def promised(name: str, number: int) -> dict[str, Any]:
    """1-sigma of every state by the linear covariance, when it has converged and at the end."""
    model, plan = problem(name).model, PLANS[name][number]
    endless = dataclasses.replace(model, window_steps=model.n_steps + 1)
    history, whole = (run_reference_filter(one, plan["design"]) for one in (model, endless))
    return {"t_end": history.t_end, "at t_end": history.sigma[-1], "at the end": whole.sigma[-1]}


def errors(found: Calibration, truth: Truth) -> np.ndarray:
    """Truth less estimate at the last sample, of rotations the vectors of what remains."""
    suite, e = found.suite, truth.states[-1] - found.states
    assert found.history is not None
    for first in suite.rotation_indices[1:]:
        block = slice(first, first + 3)
        remains = rotation_matrix(found.states[block]).T @ rotation_matrix(truth.states[-1, block])
        e[block] = rotation_vector(remains)
    e[:3] = rotation_vector(found.history.smoothed_attitude[-1] @ truth.attitude[-1].T)
    return e


def run(case: tuple[str, int, int]) -> list[dict[str, Any]]:
    """One flight of a plan, calibrated from all of it and from what the plan asks for."""
    name, number, seed = case
    p, promise, start = problem(name), promised(name, number), time.perf_counter()
    telemetry = simulate_telemetry(
        p.scenario, PLANS[name][number]["design"], seed, environment=p.environment
    )
    flown, rows = time.perf_counter() - start, []
    for when, end in (("at t_end", promise["t_end"]), ("at the end", p.scenario.duration)):
        part, start = telemetry.truncate(end), time.perf_counter()
        row: dict[str, Any] = {"key": [name, number, seed, when], "t": end, "flight s": flown}
        try:
            found = calibrate(p.scenario, part)
        except ValueError as error:
            rows.append(row | {"refused": str(error)})
            continue
        assert part.truth is not None
        e, P = errors(found, part.truth), found.covariance
        rows.append(
            row
            | {
                "calibration s": time.perf_counter() - start,
                "errors": e.tolist(),
                "sigma": np.sqrt(np.diag(P)).tolist(),
                "promised": promise[when].tolist(),
                "nees": float(e @ np.linalg.solve(P, e)),
                "nis": {test.sensor: test.nis for test in found.tests},
                "supported": bool(found.is_consistent),
                "rejected": len(found.outliers),
            }
        )
    return rows


def of(rows: Rows, name: str, when: str, number: int | None = None) -> Rows:
    """The flights of a plan, or of all of a scenario."""
    return [
        row
        for row in rows
        if (row["key"][0], row["key"][3]) == (name, when) and number in (None, row["key"][1])
    ]


def table(rows: Rows, key: str) -> np.ndarray:
    return np.array([row[key] for row in rows])


def band(n: int) -> tuple[float, float]:
    """Where the mean of n squares of standard normal numbers is."""
    low, high = chi2.ppf(BOUNDS, n) / n
    return float(low), float(high)


def plans_table(rows: Rows) -> Iterator[str]:
    yield (
        "| scenario | until [s] | flights | NEES per state (99 % bounds) | errors beyond 3σ "
        "(expected) | RMS error / claimed | claimed / predicted | supported |"
    )
    yield "| --- | ---: | ---: | --- | --- | ---: | --- | ---: |"
    for name, plans in PLANS.items():
        for number in range(len(plans)):
            for when in WHEN:
                found = of(rows, name, when, number)
                z = table(found, "errors") / table(found, "sigma")
                nees = table(found, "nees").sum() / z.size
                low, high = band(z.size)
                ratio = np.median(table(found, "sigma") / table(found, "promised"), axis=0)
                yield (
                    f"| {name} | {found[0]['t']:.0f} | {len(found)} | {nees:.3f} "
                    f"({low:.3f} to {high:.3f}){'' if low < nees < high else ' **out**'} | "
                    f"{(np.abs(z) > 3).sum()} ({2 * norm.sf(3) * z.size:.1f}) | "
                    f"{np.sqrt((z**2).mean()):.3f} | {ratio.min():.2f} to {ratio.max():.2f} | "
                    f"{sum(row['supported'] for row in found)} of {len(found)} |"
                )


def blocks_table(rows: Rows) -> Iterator[str]:
    yield "| | " + " | ".join(f"{name}, {when}" for name in PLANS for when in WHEN) + " |"
    yield "| --- |" + " ---: |" * (len(PLANS) * len(WHEN))
    for i, block in enumerate(problem("paper").model.suite.blocks):
        cells = []
        for name in PLANS:
            for when in WHEN:
                found, part = of(rows, name, when), slice(3 * i, 3 * i + 3)
                e = table(found, "errors")[:, part]
                ratios = [
                    np.sqrt(((e / table(found, key)[:, part]) ** 2).mean())
                    for key in ("sigma", "promised")
                ]
                cells.append(f"{ratios[0]:.2f}, {ratios[1]:.2f}")
        yield f"| {block} | {' | '.join(cells)} |"
    n = 3 * len(of(rows, "paper", WHEN[0]))
    low, high = np.sqrt(band(n))
    yield (
        f"| *99 % of perfect ones, {n} errors* | "
        + " | ".join([f"*{low:.2f} to {high:.2f}*"] * 4)
        + " |"
    )


def draw(rows: Rows) -> None:
    """Every error over its claimed 1-sigma, by block."""
    blocks = problem("paper").model.suite.blocks
    with mpl.rc_context({"svg.hashsalt": "basilisk", "font.size": 9}):
        figure = Figure(figsize=(9.0, 3.2), layout="constrained")
        panels = figure.subplots(1, len(PLANS), sharey=True)
        for panel, name in zip(panels, PLANS, strict=True):
            found = of(rows, name, WHEN[1])
            z = table(found, "errors") / table(found, "sigma")
            panel.axhspan(-3, 3, color="0.92")
            panel.axhspan(-1, 1, color="0.84")
            scatter = np.linspace(-0.3, 0.3, len(z))
            for i in range(len(blocks)):
                for axis, color in enumerate(("tab:red", "tab:green", "tab:blue")):
                    at, values = i + scatter, z[:, 3 * i + axis]
                    panel.plot(at, values, ".", color=color, ms=3, label="xyz"[axis])
            panel.set_xticks(range(len(blocks)), blocks, rotation=20, ha="right")
            panel.set_title(f"{name}, {len(z)} flights of two orbits")
        panels[0].set_ylabel("error / 1σ claimed")
        handles, labels = panels[0].get_legend_handles_labels()
        panels[0].legend(handles[:3], labels[:3], ncols=3, fontsize=8)
        figure.savefig(PICTURE, metadata={"Date": None})


def main(n_flights: int) -> None:
    known = {tuple(row["key"][:3]) for row in read_results(RESULTS)}
    cases = [
        (name, number, FIRST_SEED + 1000 * number + flight)  # plans are pooled: no draw twice
        for flight, number, name in product(range(n_flights), range(4), PLANS)
    ]
    with ProcessPoolExecutor(2) as pool:
        for rows in pool.map(run, [case for case in cases if case not in known]):
            for row in rows:
                add_result(RESULTS, row)
    rows = [row for row in read_results(RESULTS) if "errors" in row]
    print(*plans_table(rows), sep="\n")
    write_table(PAGE, "blocks", "\n".join(blocks_table(rows)))
    draw(rows)


if __name__ == "__main__":
    main(int(sys.argv[1]))
