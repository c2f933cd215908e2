"""Compute the data of the figure and the table of docs/validation/sensor-errors.md.

Run ``python -m tests.benchmarks.errors`` in the root of the repository. It takes a minute.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from mgeo_attitude import EnvironmentErrors, FilterModel, Scenario, evaluate
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.view.observability.improvements import build_baselines
from numpy.typing import NDArray

from .pages import DOCS, format_table, write_table

PAGE, DATA = DOCS / "validation/sensor-errors.md", DOCS / "errors.csv"

ORBITAL_PERIOD = 5992.0
N_ORBITS = 10
#: Single-axis sequence at the largest rate. The last rate is held until the end.
SEQUENCE_DESIGN = (1.0, 0.0, 0.0, 667.0, 0.0, 1.0, 0.0, 667.0, 0.0, 0.0, 1.0, 666.0)
PLOTTED_BLOCKS = ("attitude", "sun.misalignment", "sun.bias", "mag.misalignment", "mag.bias")
PLOTTED_BLOCKS += ("mag.scale_factor", "mag.nonorthogonality")
CONSTANT_BLOCKS = (
    "gyro.scale_factor",
    "gyro.misalignment",
    "gyro.nonorthogonality",
    *PLOTTED_BLOCKS[1:],
)
RATES = (0.05, 1.0)
SEQUENCES = {"z": "z only", "x y z": "x, y, z sequence"}

Floats = NDArray[np.float64]


def main() -> None:
    history = compute_history()
    history.to_csv(DATA, index=False, float_format="%.4g")
    table = build_rotation_table()
    sys.stdout.write(f"{table}\n")
    write_table(PAGE, "spins", table)


def remove_environment_errors(scenario: Scenario) -> Scenario:
    """Return the scenario with white noise and constant errors only."""
    return dataclasses.replace(scenario, environment_errors=EnvironmentErrors())


def compute_history() -> pd.DataFrame:
    """Return the 1-sigma of the worst axis of each state block over ten orbits, with and without
    environment model errors.
    """
    full = Scenario.cubesat_6u_full()
    frames = []
    for name, scenario in (("with", full), ("without", remove_environment_errors(full))):
        model = build_full_duration_model(scenario, N_ORBITS * ORBITAL_PERIOD)
        sigma = compute_worst_sigma(
            evaluate(model, np.array([SEQUENCE_DESIGN]), history=True).variances[0]
        )
        samples = np.unique(np.geomspace(60, model.n_steps, 150).astype(np.int64))
        frame = pd.DataFrame({"errors": name, "time [s]": model.times[samples]})
        for i, unit in enumerate(list_block_units(model.suite)):
            if model.suite.blocks[i] in PLOTTED_BLOCKS:
                column = f"{unit.label} [{unit.unit}]"
                frame[column] = sigma[samples, i] * unit.factor
        frames.append(frame)
    return pd.concat(frames)


def build_rotation_table() -> str:
    """Return a table of the fraction of the initial 1-sigma that remains after one orbit, for each
    constant state block and plan.
    """
    scenario = Scenario.cubesat_6u_full()
    model = build_full_duration_model(scenario, ORBITAL_PERIOD)
    designs = {"none": (0.0, 0.0, 0.0, 0.0)}
    for name, sequence in SEQUENCES.items():
        for rate in RATES:
            designs[f"{name}, {rate:g}"] = build_baselines(scenario, 2000.0, rate)[sequence]
    there_and_back = build_baselines(scenario, 2000.0, 1.0)["x, y, z sequence, both directions"]
    designs["x y z, both directions, 1"] = there_and_back
    designs |= select_front_plans()
    columns = []
    for design in designs.values():
        variances = evaluate(model, np.array([design]), history=True).variances[0]
        fractions = compute_worst_sigma(variances[-1] / model.initial_sigma**2)
        block_indices = [model.suite.blocks.index(block) for block in CONSTANT_BLOCKS]
        columns.append([format_fraction(fractions[index]) for index in block_indices])
    rows = [[f"`{block}`", *cells] for block, *cells in zip(CONSTANT_BLOCKS, *columns, strict=True)]
    return format_table(["remaining [%], rates in deg/s", *designs], rows)


def select_front_plans() -> Mapping[str, Sequence[float]]:
    """Return the middle and the last plan of the front of `cubesat_6u` in docs/fronts, by name."""
    front = pd.read_csv(DOCS / "fronts" / "free.csv").sort_values("t_end [s]")
    selected = front.iloc[[len(front) // 2, -1]]
    designs = selected.filter(regex="^(omega|duration)").to_numpy()
    names = [f"plan of {t:.0f} s" for t in selected["t_end [s]"]]
    return dict(zip(names, designs.tolist(), strict=True))


def build_full_duration_model(scenario: Scenario, duration: float) -> FilterModel:
    """Return the filter model of a scenario with another duration, without end at convergence."""
    convergence = dataclasses.replace(scenario.convergence, rule="trace", window=duration)
    modified = dataclasses.replace(scenario, duration=duration, convergence=convergence)
    return FilterModel.from_scenario(modified)


def compute_worst_sigma(variances: Floats) -> Floats:
    """Return the 1-sigma of the worst axis of each state block, shape (..., n_blocks)."""
    sigma: Floats = np.sqrt(variances.reshape(*variances.shape[:-1], -1, 3).max(axis=-1))
    return sigma


def format_fraction(value: float) -> str:
    """Format a fraction in percent, in bold below one half."""
    text = f"{100.0 * value:.0f}" if value > 0.1 else f"{100.0 * value:.1f}"
    return f"**{text}**" if value < 0.5 else text


if __name__ == "__main__":
    main()
