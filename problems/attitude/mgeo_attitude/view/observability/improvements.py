"""Comparison of a plan with simple maneuvers, and changes that would reduce its 1-sigmas."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.error_budget import (
    GYRO_NOISE,
    format_drift,
    format_initial_error,
    format_sensor_noise,
)
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.actuation import MagnetorquerDrive
from mgeo_attitude.maneuvers.motion import HOLD_LABEL, Phase
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import scale_noise
from mgeo_attitude.sensors.suite import Suite, list_block_units
from mgeo_attitude.view.summaries import compute_worst_axes

_AXES = np.eye(3)


def build_baselines(
    scenario: Scenario, duration: float, rate_deg_s: float | None = None
) -> dict[str, tuple[float, ...]]:
    """Build simple designs for comparison with a plan, such as rotations about one body axis.

    Parameters
    ----------
    scenario : Scenario
    duration : float
        Total duration of the maneuvers of each design [s]. The last rate is held afterwards.
    rate_deg_s : float, optional
        Body rate about each axis [deg/s]; default: the scenario's maximum.

    Returns
    -------
    dict
        ``no maneuver``; ``x only``, ``y only`` and ``z only``; ``x, y, z sequence``, a third of the
        duration about each axis; and ``x, y, z sequence, both directions``, with a positive and
        then a negative rate about each axis.
    """
    rate = scenario.maneuvers.max_rate_deg_s if rate_deg_s is None else rate_deg_s
    forward = rate * _AXES
    both_directions = np.stack([forward, -forward], axis=1).reshape(-1, 3)
    return {
        "no maneuver": _divide_equally(np.zeros((1, 3)), duration),
        **{f"{axis} only": _divide_equally(forward[[i]], duration) for i, axis in enumerate("xyz")},
        "x, y, z sequence": _divide_equally(forward, duration),
        "x, y, z sequence, both directions": _divide_equally(both_directions, duration),
    }


def build_matching_baselines(
    scenario: Scenario, phases: Iterable[Phase]
) -> dict[str, tuple[float, ...]]:
    """Build simple designs, such as rotations about one body axis, with the maneuver duration of a
    plan.

    Parameters
    ----------
    scenario : Scenario
    phases : iterable of Phase
        Phases of the plan until its convergence.

    Returns
    -------
    dict of str to tuple of float
        Design vectors by name.
    """
    maneuvers = (phase.duration for phase in phases if phase.label != HOLD_LABEL)
    return build_baselines(scenario, max(sum(maneuvers), scenario.step))


def compare_designs(
    problem: AttitudeManeuverProblem, designs: Mapping[str, ArrayLike], time: float
) -> pd.DataFrame:
    """Compare the traces and worst-axis 1-sigmas of several designs at the same time.

    The filter need not have converged at that time.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
    designs : mapping of str to array_like, shape (4 m,)
        The number m of maneuvers may differ between designs.
    time : float
        Time of the comparison [s], a step of the filter; usually the t_end of a plan.

    Returns
    -------
    DataFrame
        One row per design. ``t_end [s]`` and ``trace at t_end [-]`` belong to the convergence of
        the design; ``trace [-]`` is the trace at the common time, and ``trace / first trace [-]``
        its ratio to that of the first design. One column per 3-vector of the state has the 1-sigma
        of the worst body axis at the common time.

    Raises
    ------
    ValueError
        If the length of a design is not a multiple of 4.
    """
    model = problem.model
    step = round(time / model.step)
    X = _stack_designs([np.asarray(design, dtype=float) for design in designs.values()])
    converged = evaluate(model, X, problem.threads)
    variances = evaluate(model.full_duration_model, X, problem.threads, history=True).variances[
        :, step
    ]
    trace = variances @ model.weights
    columns: dict[str, object] = {
        "t_end [s]": converged.t_end,
        "trace at t_end [-]": converged.trace,
        "trace [-]": trace,
        "trace / first trace [-]": trace / trace[0],
    }
    columns |= compute_worst_axes(model.suite, np.sqrt(variances))
    return pd.DataFrame(columns, index=list(designs))


def _divide_equally(rates_deg_s: np.ndarray, duration: float) -> tuple[float, ...]:
    share = np.full((len(rates_deg_s), 1), duration / len(rates_deg_s))
    return tuple(np.hstack([rates_deg_s, share]).ravel().tolist())


def _stack_designs(designs: list[np.ndarray]) -> np.ndarray:
    """Stack designs as rows, padding short designs with leading zero-duration maneuvers."""
    longest = max(design.size for design in designs)
    if any(design.size % VARIABLES_PER_MANEUVER or design.ndim != 1 for design in designs):
        raise ValueError(
            f"designs of shapes {[design.shape for design in designs]}: expected 4 variables for "
            "each maneuver"
        )
    return np.array([np.append(np.zeros(longest - design.size), design) for design in designs])


#: Factor on error sources.
_IMPROVEMENT_FACTOR = 0.5
#: Additional duration [s].
_EXTRA_DURATION = 300.0

#: Beginning of the names of changes that make the plan longer.
EXTRA_DURATION_PREFIX = f"{_EXTRA_DURATION:g} s more"
UNCHANGED = "unchanged"


def evaluate_improvements(
    model: FilterModel, design: ArrayLike, t_end: float, rate_deg_s: float
) -> pd.DataFrame:
    """Compute the worst-axis 1-sigmas of a plan after changes such as a halved error source.

    The error sources are those of `filter.error_budget`: initial 1-sigmas, gyro noise, drift of the
    gyro bias, and sensor noise. A longer plan has 300 s more at the last rate, or 300 s more of
    rotation about a body axis after holding the last rate until `t_end`. Each change is one run of
    the filter. Constraints are not evaluated. Longer plans are omitted if the scenario ends
    earlier, and rotations are omitted for magnetorquers.

    Parameters
    ----------
    model : FilterModel
    design : array_like, shape (4 m,)
    t_end : float
        Time at which the unchanged design is evaluated [s].
    rate_deg_s : float
        Rate of the additional rotation [deg/s].

    Returns
    -------
    DataFrame
        One row per change, the first one being ``unchanged``; rows of halved error sources have the
        names of the sources. One column per 3-vector of the state, in the unit that the column name
        contains.
    """
    units, step = list_block_units(model.suite), round(t_end / model.step)
    rows = {UNCHANGED: _compute_sigma(model, design, step)}
    for block, unit in enumerate(units):
        sigma = model.initial_sigma.copy()
        sigma[3 * block : 3 * block + 3] *= _IMPROVEMENT_FACTOR
        improved_model = dataclasses.replace(model, initial_sigma=sigma)
        rows[format_initial_error(unit.label)] = _compute_sigma(improved_model, design, step)
    for name, suite in _halve_noise(model.suite):
        improved_model = dataclasses.replace(model, suite=suite)
        rows[name] = _compute_sigma(improved_model, design, step)
    longer = step + round(_EXTRA_DURATION / model.step)
    if longer <= model.n_steps:
        rows[f"{EXTRA_DURATION_PREFIX}, last rate"] = _compute_sigma(model, design, longer)
        for name, extended in _add_rotations(model, design, t_end, rate_deg_s):
            rows[f"{EXTRA_DURATION_PREFIX}, about {name}"] = _compute_sigma(model, extended, longer)
    columns = [f"{unit.label} [{unit.unit}]" for unit in units]
    factors = np.array([unit.factor for unit in units])
    table = pd.DataFrame(np.array(list(rows.values())) * factors, columns=columns)
    return table.set_index(pd.Index(rows, name="change"))


def _compute_sigma(model: FilterModel, design: ArrayLike, step: int) -> Floats:
    """Return the worst-axis 1-sigma of each 3-vector in the state, in filter units."""
    result = evaluate(
        model.full_duration_model, np.atleast_2d(np.asarray(design, dtype=float)), 1, history=True
    )
    worst: Floats = np.sqrt(result.variances[0, step].reshape(-1, 3).max(axis=1))
    return worst


def _halve_noise(suite: Suite) -> Iterator[tuple[str, Suite]]:
    gyro, sensors = suite.gyro, suite.sensors
    yield GYRO_NOISE, dataclasses.replace(suite, gyro=scale_noise(gyro, _IMPROVEMENT_FACTOR))
    if any(gyro.effective_rate_random_walk):
        x, y, z = (_IMPROVEMENT_FACTOR * walk for walk in gyro.effective_rate_random_walk)
        steadier = dataclasses.replace(
            gyro, bias_instability_deg_per_h=None, rate_random_walk=(x, y, z)
        )
        yield format_drift("gyro bias"), dataclasses.replace(suite, gyro=steadier)
    for i, sensor in enumerate(sensors):
        if sensor.noise_parameters:
            quieter = scale_noise(sensor, _IMPROVEMENT_FACTOR)
            changed = (*sensors[:i], quieter, *sensors[i + 1 :])
            yield format_sensor_noise(sensor), dataclasses.replace(suite, sensors=changed)


def _add_rotations(
    model: FilterModel, design: ArrayLike, t_end: float, rate_deg_s: float
) -> Iterator[tuple[str, Floats]]:
    """Yield designs that hold the last rate until `t_end` and then rotate about one body axis."""
    if isinstance(model.slew_limits, MagnetorquerDrive):
        return
    maneuvers = np.array(design, dtype=float).reshape(-1, VARIABLES_PER_MANEUVER)
    maneuvers[-1, 3] = max(t_end - maneuvers[:-1, 3].sum(), 0.0)
    for axis, direction in zip("xyz", rate_deg_s * np.eye(3), strict=True):
        yield axis, np.append(maneuvers, [*direction, _EXTRA_DURATION])
