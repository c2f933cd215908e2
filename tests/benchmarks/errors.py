"""Compute the data of the figure and the table of docs/errors.md.

    python -m tests.benchmarks.errors

Run it in the repository's root; it takes a minute.
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

from .pages import DOCS, markdown, write_table

DOCUMENT, DATA = DOCS / "errors.md", DOCS / "errors.csv"

ORBIT = 5992.0
ORBITS = 10
#: Each axis in turn at the greatest rate, then about z until the end.
SWEEP = (1.0, 0.0, 0.0, 667.0, 0.0, 1.0, 0.0, 667.0, 0.0, 0.0, 1.0, 666.0)
FLOORED = ("attitude", "sun.misalignment", "sun.bias", "mag.misalignment", "mag.bias")
FLOORED += ("mag.scale_factor", "mag.nonorthogonality")
CONSTANTS = ("gyro.scale_factor", "gyro.misalignment", "gyro.nonorthogonality", *FLOORED[1:])
RATES = (0.05, 1.0)
SPINS = {"z": "z only", "x y z": "x, y, z sequence"}

Floats = NDArray[np.float64]


def main() -> None:
    history = floor()
    history.to_csv(DATA, index=False, float_format="%.4g")
    table = spin_table()
    sys.stdout.write(f"{table}\n")
    write_table(DOCUMENT, "spins", table)


def without_varying(scenario: Scenario) -> Scenario:
    """The same with white noise and constants alone."""
    return dataclasses.replace(scenario, environment_errors=EnvironmentErrors())


def floor() -> pd.DataFrame:
    """1-sigma of the worst axis over ten orbits, with and without errors that vary."""
    full = Scenario.cubesat_6u_full()
    frames = []
    for name, scenario in (("with", full), ("without", without_varying(full))):
        model = endless(scenario, ORBITS * ORBIT)
        sigma = worst(evaluate(model, np.array([SWEEP]), history=True).variances[0])
        wanted = np.unique(np.geomspace(60, model.n_steps, 150).astype(np.int64))
        frame = pd.DataFrame({"errors": name, "time [s]": model.times[wanted]})
        for i, unit in enumerate(list_block_units(model.suite)):
            if model.suite.blocks[i] in FLOORED:
                column = f"{unit.label} [{unit.unit}]"
                frame[column] = sigma[wanted, i] * unit.factor
        frames.append(frame)
    return pd.concat(frames)


def spin_table() -> str:
    """Share of each constant's initial 1-sigma that is left after an orbit, worst axis."""
    scenario = Scenario.cubesat_6u_full()
    model = endless(scenario, ORBIT)
    designs = {"none": (0.0, 0.0, 0.0, 0.0)}
    for name, spin in SPINS.items():
        for rate in RATES:
            designs[f"{name}, {rate:g}"] = build_baselines(scenario, 2000.0, rate)[spin]
    there_and_back = build_baselines(scenario, 2000.0, 1.0)["x, y, z sequence, both directions"]
    designs["there and back, 1"] = there_and_back
    designs |= front_plans()
    columns = []
    for design in designs.values():
        variances = evaluate(model, np.array([design]), history=True).variances[0]
        left = worst(variances[-1] / model.initial_sigma**2)
        places = [model.suite.blocks.index(block) for block in CONSTANTS]
        columns.append([share(left[place]) for place in places])
    rows = [[f"`{block}`", *cells] for block, *cells in zip(CONSTANTS, *columns, strict=True)]
    return markdown(["left [%], spins in deg/s", *designs], rows)


def front_plans() -> Mapping[str, Sequence[float]]:
    """Middle and last plan of the front of `cubesat_6u` in docs/fronts."""
    front = pd.read_csv(DOCS / "fronts" / "free.csv").sort_values("t_end [s]")
    chosen = front.iloc[[len(front) // 2, -1]]
    designs = chosen.filter(regex="^(omega|duration)").to_numpy()
    names = [f"plan of {t:.0f} s" for t in chosen["t_end [s]"]]
    return dict(zip(names, designs.tolist(), strict=True))


def endless(scenario: Scenario, duration: float) -> FilterModel:
    """The model of a scenario of a duration that runs to its end."""
    convergence = dataclasses.replace(scenario.convergence, rule="trace", window=duration)
    longer = dataclasses.replace(scenario, duration=duration, convergence=convergence)
    return FilterModel.from_scenario(longer)


def worst(variances: Floats) -> Floats:
    """1-sigma of the worst axis of each 3-vector, shape (..., n_blocks)."""
    sigma: Floats = np.sqrt(variances.reshape(*variances.shape[:-1], -1, 3).max(axis=-1))
    return sigma


def share(value: float) -> str:
    """Bold where less than half is left."""
    text = f"{100.0 * value:.0f}" if value > 0.1 else f"{100.0 * value:.1f}"
    return f"**{text}**" if value < 0.5 else text


if __name__ == "__main__":
    main()
