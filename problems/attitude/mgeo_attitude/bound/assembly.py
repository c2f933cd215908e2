"""The limit of a scenario, equations (20) to (29), and what it does not ask for, by name."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.bound.common_mode import Carrier, common_modes
from mgeo_attitude.bound.curves import (
    Block,
    LimitCurves,
    curves,
    in_any_axes,
    in_these_axes,
    least,
    unobserved,
)
from mgeo_attitude.bound.gyro import Drift, along_attitude, corners, recursion, through_attitude
from mgeo_attitude.bound.samples import NoLimit, Samples, samples
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.gyro import is_uneven
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.suite import Suite


def limit(scenario: Scenario, model: FilterModel | None = None) -> LimitCurves:
    """What no plan of a scenario is below, whatever its maneuvers.

    It is a bound of the filter's covariance at each time, for every history of the attitude at
    rates that maneuvers may have; where coils turn the satellite, at any rate. Plans are flown
    exactly.

    Parameters
    ----------
    scenario : Scenario
    model : FilterModel, optional
        That of the scenario, which saves making it.

    Raises
    ------
    NoLimit
        Where none can be proved, and why.

    Examples
    --------
    >>> from mgeo_attitude import Scenario, limit
    >>> curves = limit(Scenario.paper())
    >>> curves.trace[[600, 1800]].round(8)
    array([1.919e-05, 6.100e-06])
    """
    model = FilterModel.from_scenario(scenario) if model is None else model
    return _limit(scenario, model, samples(model))


def _limit(scenario: Scenario, model: FilterModel, told: Samples) -> LimitCurves:
    known = _information(model)
    greatest = np.radians(scenario.maneuvers.max_rate_deg_s)
    rates = np.maximum(greatest, np.abs(model.initial_rate))
    found = dict(_inertial(model, told, known))
    free = scenario.turned_by_coils  # which reach a rate, and then let go
    found |= dict(_of_gyro(model, told, known, rates, free))
    found |= dict(_of_sensors(model, told, known))
    angle = np.pi if free else float(np.linalg.norm(rates)) * model.step
    for name, total in _common_modes(model, told, known, angle):
        found[name] = found[name].or_above_sum(total)
    found |= dict(_considered(model))
    return curves(scenario, model, found, given_away(scenario, model, told))


def _inertial(model: FilterModel, told: Samples, known: Floats) -> Iterator[tuple[str, Block]]:
    """Of what no attitude changes in axes along GCRS, all of it together: equation (22)."""
    suite, names = model.suite, told.inertial
    places = np.concatenate([_states(suite, name) for name in names])
    axes = np.eye(len(places))
    axes[:3, :3] = model.initial_attitude
    start = np.linalg.inv(axes.T @ known[np.ix_(places, places)] @ axes)
    walks = suite.diffusion()[:3] * model.step
    decay, noise = np.repeat([(1.0, walks.min())], 3 * len(names), axis=0).T
    for i, name in enumerate(names[1:], start=1):
        own = slice(3 * i, 3 * i + 3)
        decay[own], noise[own] = suite.processes[name].over(model.step)
    covariances = recursion(start, decay, noise, told.together)
    for i, name in enumerate(names):
        own = slice(3 * i, 3 * i + 3)
        block = in_these_axes(covariances[:, own, own])
        if name == "attitude":  # in body axes, which may share it evenly
            block = block._replace(worst=block.total / 3.0)
            if told.uneven or np.ptp(walks):
                block = block.or_above(_mean(told.attitude, known[:3, :3], 1.0, harmonic(walks)))
        yield name, block


def _mean(told: Floats, known: Floats, decay: float, noise: float) -> Block:
    """Of a 3-vector from traces alone: a recursion of the mean eigenvalue, equation (24)."""
    start = np.array([[3.0 / np.trace(known)]])
    variances = recursion(start, np.array([decay]), np.array([noise]), told[:, None, None] / 3.0)
    return in_any_axes(np.repeat(variances[:, 0], 3, axis=1))


def harmonic(values: Floats) -> float:
    """Their mean: of densities the noise that tells as much in all as these, if it is even."""
    return float(len(values) / np.sum(1.0 / values))


def _of_gyro(
    model: FilterModel, told: Samples, known: Floats, rates: Floats, free: bool
) -> Iterator[tuple[str, Block]]:
    """Of the gyro's errors: equations (25) and (26)."""
    suite, times = Suite(model.suite.gyro, ()), model.times
    walks, matrices = suite.diffusion(), np.array(list(map(suite.dynamics_matrix, corners(rates))))
    attitude, walk = known[:3, :3], harmonic(walks[:3])
    for name in suite.blocks[1:]:
        own = _states(suite, name)
        gain = float(np.linalg.norm(matrices[:, :3, own], 2, axis=(1, 2)).max())
        drift = Drift(gain, -matrices[0][own[0], own[0]], walks[own].min())
        start = np.inf if known[:3, own].any() else float(np.trace(attitude))
        of_own = known[np.ix_(own, own)]
        block = in_any_axes(through_attitude(times, drift, of_own, told.attitude, start, walk))
        at_any_rate = (matrices[:, :3, own] == matrices[0, :3, own]).all()
        if free and not at_any_rate:
            raise NoLimit(
                f"{name}: how it turns the attitude depends on the rate, which coils leave free"
            )
        if at_any_rate:
            known_all_along = along_attitude(times, drift, of_own, walks[:3].min())
            block = block.or_above(in_any_axes(known_all_along))
        yield name, block


def _of_sensors(model: FilterModel, told: Samples, known: Floats) -> Iterator[tuple[str, Block]]:
    """Of sensors' other errors, all else known: equation (23)."""
    for name, samples_tell in told.own.items():
        own = _states(model.suite, name)
        start, process = known[np.ix_(own, own)], model.suite.processes.get(name)
        if process is not None:
            decay, noise = process.over(model.step)
            yield name, _mean(samples_tell.trace, start, decay, harmonic(np.broadcast_to(noise, 3)))
        elif samples_tell.matrix is not None:
            gained = np.cumsum(samples_tell.matrix, axis=0)
            yield name, in_these_axes(np.linalg.inv(start + gained))
        else:
            yield name, least(start, np.cumsum(samples_tell.trace))


def _common_modes(
    model: FilterModel, told: Samples, known: Floats, angle: float
) -> Iterator[tuple[str, Floats]]:
    """Of errors that turn with the body and read like others that do not: equation (28)."""
    suite = model.suite
    if (model.initial_correlation != np.eye(len(known))).any():
        return
    states = {name: _states(suite, name) for name in suite.blocks}
    start = {name: known[np.ix_(own, own)] for name, own in states.items()}
    for name in told.inertial:
        decay, noise = 1.0, suite.diffusion()[:3] * model.step
        if name != "attitude":
            decay, noise = suite.processes[name].over(model.step)
        carrier = Carrier(float(decay), float(np.min(noise)), start[name])
        looks = [look for look in told.looks if look.carrier == name]
        yield from common_modes(name, carrier, looks, start, angle)


def _considered(model: FilterModel) -> Iterator[tuple[str, Block]]:
    """Of errors that no plan changes, exactly."""
    suite = model.suite
    diffusion, start = suite.diffusion(), model.initial_covariance
    rest = suite.dynamics_matrix(np.zeros(3))
    for name in suite.considered_blocks:
        own = _states(suite, name)
        varies = own[0] < suite.n_dynamic
        decay, walk = (-rest[own[0], own[0]], diffusion[own]) if varies else (0.0, np.zeros(3))
        now = unobserved(start[np.ix_(own, own)], decay, walk, model.times)
        yield name, in_these_axes(now)


def _information(model: FilterModel) -> Floats:
    """Inverse of the initial covariance, by blocks what is known of each, all else known."""
    sigma = model.initial_sigma
    return np.linalg.inv(model.initial_correlation) / np.outer(sigma, sigma)


def _states(suite: Suite, block: str) -> np.ndarray:
    return 3 * suite.blocks.index(block) + np.arange(3)


def given_away(scenario: Scenario, model: FilterModel, told: Samples) -> tuple[str, ...]:
    """Each in one line, beside that each 3-vector counts as if all else were known."""
    uneven = (*(["gyro"] if is_uneven(model.suite.diffusion()) else []), *told.uneven)
    found = [f"{name}: noise counts as nowhere more than on its best axis" for name in uneven]
    diodes = [each.name for each in model.suite.sensors if isinstance(each, Photodiode)]
    if diodes:
        found.append(f"{', '.join(diodes)}: the Sun is where all together tell most")
    for sensor in model.suite.sensors:
        if sensor.views() and sensor.name not in diodes:
            found.append(f"{sensor.name}: sees whatever the attitude")
        if sensor.max_rate() < np.inf:
            found.append(f"{sensor.name}: measures at any rate")
    if (model.initial_correlation != np.eye(len(model.initial_sigma))).any():
        found.append("correlations at the start: of each 3-vector what is not known by the others")
    if model.suite.considered.size:
        found.append("considered errors count as known, but for themselves")
    if len(model.suite.gyro.states()) > 1:
        found.append("gyro errors that turn with the rate: any attitude, at the greatest rates")
    turning = [
        ("coils" if scenario.turned_by_coils else "ramps", model.slew_limits),
        ("path limits", model.path_limits),
        ("wheels", scenario.wheels),
    ]
    found += [f"{name}: the attitude is free" for name, there in turning if there]
    return tuple(found)
