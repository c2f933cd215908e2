"""What would make a plan's 1-sigmas smaller, as the filter itself says when it is run again."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.drives import CoilDrive
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.sensors.base import with_noise
from mgeo_attitude.sensors.suite import Suite, block_units

#: By what initial errors and noise are multiplied.
_FACTOR = 0.5
#: For how much longer a plan goes on [s].
_LONGER = 300.0

AS_IT_IS = "as it is"


def remedies(
    model: FilterModel, design: ArrayLike, t_end: float, rate_deg_s: float
) -> pd.DataFrame:
    """1-sigma of the worst body axis if one thing were better, each by a run of the filter.

    That is half of an initial 1-sigma, half of the noise of gyro or of a sensor, 300 s more at the
    last rate, and 300 s more in a turn about a body axis at `rate_deg_s`, once the last rate has
    been held until `t_end`. Limits are not looked at. More time is left out where the run ends
    sooner, turns where coils turn the body.

    Returns
    -------
    DataFrame
        A row for each, the first ``as it is``; a column for each 3-vector of the state, in the unit
        its name carries.
    """
    units, step = block_units(model.suite), round(t_end / model.step)
    rows = {AS_IT_IS: _sigma(model, design, step)}
    for block, unit in enumerate(units):
        sigma = model.initial_sigma.copy()
        sigma[3 * block : 3 * block + 3] *= _FACTOR
        better = dataclasses.replace(model, initial_sigma=sigma)
        rows[f"half the initial {unit.label}"] = _sigma(better, design, step)
    for name, suite in _quieter(model.suite):
        better = dataclasses.replace(model, suite=suite)
        rows[f"half the noise of {name}"] = _sigma(better, design, step)
    longer = step + round(_LONGER / model.step)
    if longer <= model.n_steps:
        rows[f"{_LONGER:g} s more at the last rate"] = _sigma(model, design, longer)
        for name, turned in _turned(model, design, t_end, rate_deg_s):
            rows[f"{_LONGER:g} s more about body {name}"] = _sigma(model, turned, longer)
    columns = [f"{unit.label} [{unit.unit}]" for unit in units]
    factors = np.array([unit.factor for unit in units])
    found = pd.DataFrame(np.array(list(rows.values())) * factors, columns=columns)
    return found.set_index(pd.Index(rows, name="change"))


def most(values: pd.Series, least: float = 0.02) -> pd.Series:
    """The two changes of a column of `remedies` that save most, more than a share `least`."""
    worth = values[values < (1.0 - least) * values[AS_IT_IS]]
    two: pd.Series = worth.sort_values(kind="stable")[:2]
    return two


def _sigma(model: FilterModel, design: ArrayLike, step: int) -> Floats:
    """1-sigma of the worst axis of each block after a step, filter's units."""
    ran = evaluate(model.endless, np.atleast_2d(np.asarray(design, dtype=float)), 1, history=True)
    worst: Floats = np.sqrt(ran.variances[0, step].reshape(-1, 3).max(axis=1))
    return worst


def _quieter(suite: Suite) -> Iterator[tuple[str, Suite]]:
    """The suite with half the noise of the gyro, and of each sensor that names its parameters."""
    parts: list[Any] = [suite.gyro, *suite.sensors]
    for i, part in enumerate(parts):
        if not part.noise_parameters:
            continue
        better = [*parts[:i], with_noise(part, _FACTOR), *parts[i + 1 :]]
        yield "gyro" if i == 0 else part.name, Suite(better[0], tuple(better[1:]), suite.world)


def _turned(
    model: FilterModel, design: ArrayLike, t_end: float, rate_deg_s: float
) -> Iterator[tuple[str, Floats]]:
    """The design with its last maneuver held until `t_end`, and then a turn about one axis."""
    if isinstance(model.slew_limits, CoilDrive):
        return
    held = np.array(design, dtype=float).reshape(-1, VARIABLES_PER_MANEUVER)
    held[-1, 3] = max(t_end - held[:-1, 3].sum(), 0.0)
    for axis, direction in zip("xyz", rate_deg_s * np.eye(3), strict=True):
        yield axis, np.append(held, [*direction, _LONGER])
