"""Lower bound of a scenario, equations (20) to (29), and the relaxations behind it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.lower_bound.common_mode import Carrier, bound_common_modes
from mgeo_attitude.lower_bound.curves import (
    BlockBounds,
    LowerBound,
    assemble_bounds,
    bounds_from_covariances,
    bounds_from_eigenvalues,
    bounds_from_information,
    propagate_unobserved,
)
from mgeo_attitude.lower_bound.gyro import (
    GyroErrorDynamics,
    bound_through_attitude,
    bound_with_known_attitude,
    rate_box_corners,
    run_covariance_recursion,
)
from mgeo_attitude.lower_bound.samples import (
    NoLowerBoundError,
    SampleInformation,
    collect_information,
)
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.gyro import has_axis_dependent_noise
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.suite import Suite


def compute_lower_bound(scenario: Scenario, model: FilterModel | None = None) -> LowerBound:
    """Return lower bounds of the covariance over all plans of a scenario, as functions of time.

    At each time the bound holds for every attitude history at rates that maneuvers may have, or at
    any rate with magnetorquer control. Plans are nominal, without execution errors.

    Parameters
    ----------
    scenario : Scenario
    model : FilterModel, optional
        Model of the scenario, if already built.

    Raises
    ------
    NoLowerBoundError
        If no lower bound can be proved for the scenario.

    Examples
    --------
    >>> from mgeo_attitude import Scenario, limit
    >>> curves = limit(Scenario.paper())
    >>> curves.trace[[600, 1800]].round(8)
    array([1.919e-05, 6.100e-06])
    """
    model = FilterModel.from_scenario(scenario) if model is None else model
    return _assemble_lower_bound(scenario, model, collect_information(model))


def _assemble_lower_bound(
    scenario: Scenario, model: FilterModel, information: SampleInformation
) -> LowerBound:
    prior = _invert_initial_covariance(model)
    greatest = np.radians(scenario.maneuvers.max_rate_deg_s)
    rates = np.maximum(greatest, np.abs(model.initial_rate))
    bounds = dict(_bound_inertial(model, information, prior))
    free = scenario.is_magnetorquer_driven  # Magnetorquers release the body after a slew.
    bounds |= dict(_bound_gyro(model, information, prior, rates, free))
    bounds |= dict(_bound_sensors(model, information, prior))
    angle = np.pi if free else float(np.linalg.norm(rates)) * model.step
    for name, total in _bound_common_modes(model, information, prior, angle):
        bounds[name] = bounds[name].raise_to_sum(total)
    bounds |= dict(_bound_considered(model))
    return assemble_bounds(scenario, model, bounds, list_relaxations(scenario, model, information))


def _bound_inertial(
    model: FilterModel, information: SampleInformation, prior: Floats
) -> Iterator[tuple[str, BlockBounds]]:
    """Yield joint bounds of the blocks with attitude-independent information, equation (22)."""
    suite, names = model.suite, information.inertial_blocks
    places = np.concatenate([_list_block_states(suite, name) for name in names])
    axes = np.eye(len(places))
    axes[:3, :3] = model.initial_attitude
    start = np.linalg.inv(axes.T @ prior[np.ix_(places, places)] @ axes)
    walks = suite.compute_noise_density()[:3] * model.step
    decay, noise = np.repeat([(1.0, walks.min())], 3 * len(names), axis=0).T
    for i, name in enumerate(names[1:], start=1):
        own = slice(3 * i, 3 * i + 3)
        decay[own], noise[own] = suite.processes[name].discretize(model.step)
    covariances = run_covariance_recursion(start, decay, noise, information.joint)
    for i, name in enumerate(names):
        own = slice(3 * i, 3 * i + 3)
        block = bounds_from_covariances(covariances[:, own, own])
        if name == "attitude":  # Body axes may share the variance evenly.
            block = block._replace(max_variance=block.variance_sum / 3.0)
            if information.anisotropic_sensors or np.ptp(walks):
                block = block.combine_with(
                    _bound_by_mean(
                        information.attitude_trace, prior[:3, :3], 1.0, harmonic_mean(walks)
                    )
                )
        yield name, block


def _bound_by_mean(traces: Floats, prior: Floats, decay: float, noise: float) -> BlockBounds:
    """Bound a 3-vector by a recursion of the mean eigenvalue, from traces alone, equation (24)."""
    start = np.array([[3.0 / np.trace(prior)]])
    variances = run_covariance_recursion(
        start, np.array([decay]), np.array([noise]), traces[:, None, None] / 3.0
    )
    return bounds_from_eigenvalues(np.repeat(variances[:, 0], 3, axis=1))


def harmonic_mean(values: Floats) -> float:
    """Return the harmonic mean of noise densities.

    Isotropic noise of this density gives the same total information as the anisotropic noise.
    """
    return float(len(values) / np.sum(1.0 / values))


def _bound_gyro(
    model: FilterModel,
    information: SampleInformation,
    prior: Floats,
    max_rates: Floats,
    is_rate_free: bool,
) -> Iterator[tuple[str, BlockBounds]]:
    """Yield bounds of the gyro errors, equations (25) and (26)."""
    suite, times = Suite(model.suite.gyro, ()), model.times
    walks, matrices = (
        suite.compute_noise_density(),
        np.array(list(map(suite.dynamics_matrix, rate_box_corners(max_rates)))),
    )
    attitude, walk = prior[:3, :3], harmonic_mean(walks[:3])
    for name in suite.blocks[1:]:
        own = _list_block_states(suite, name)
        gain = float(np.linalg.norm(matrices[:, :3, own], 2, axis=(1, 2)).max())
        drift = GyroErrorDynamics(gain, -matrices[0][own[0], own[0]], walks[own].min())
        start = np.inf if prior[:3, own].any() else float(np.trace(attitude))
        of_own = prior[np.ix_(own, own)]
        block = bounds_from_eigenvalues(
            bound_through_attitude(times, drift, of_own, information.attitude_trace, start, walk)
        )
        at_any_rate = (matrices[:, :3, own] == matrices[0, :3, own]).all()
        if is_rate_free and not at_any_rate:
            raise NoLowerBoundError(
                f"{name}: no lower bound is known, because its effect on the attitude depends on "
                "the rate, which magnetorquers do not constrain"
            )
        if at_any_rate:
            variances = bound_with_known_attitude(times, drift, of_own, walks[:3].min())
            block = block.combine_with(bounds_from_eigenvalues(variances))
        yield name, block


def _bound_sensors(
    model: FilterModel, information: SampleInformation, prior: Floats
) -> Iterator[tuple[str, BlockBounds]]:
    """Yield bounds of the sensor errors if all other states are known, equation (23)."""
    for name, samples_tell in information.blocks.items():
        own = _list_block_states(model.suite, name)
        start, process = prior[np.ix_(own, own)], model.suite.processes.get(name)
        if process is not None:
            decay, noise = process.discretize(model.step)
            yield (
                name,
                _bound_by_mean(
                    samples_tell.trace, start, decay, harmonic_mean(np.broadcast_to(noise, 3))
                ),
            )
        elif samples_tell.matrix is not None:
            gained = np.cumsum(samples_tell.matrix, axis=0)
            yield name, bounds_from_covariances(np.linalg.inv(start + gained))
        else:
            yield name, bounds_from_information(start, np.cumsum(samples_tell.trace))


def _bound_common_modes(
    model: FilterModel, information: SampleInformation, prior: Floats, max_angle: float
) -> Iterator[tuple[str, Floats]]:
    """Yield bounds of body-fixed errors that look like inertial errors, equation (28)."""
    suite = model.suite
    if (model.initial_correlation != np.eye(len(prior))).any():
        return
    states = {name: _list_block_states(suite, name) for name in suite.blocks}
    start = {name: prior[np.ix_(own, own)] for name, own in states.items()}
    for name in information.inertial_blocks:
        decay, noise = 1.0, suite.compute_noise_density()[:3] * model.step
        if name != "attitude":
            decay, noise = suite.processes[name].discretize(model.step)
        carrier = Carrier(float(decay), float(np.min(noise)), start[name])
        looks = [look for look in information.carriers if look.carrier == name]
        yield from bound_common_modes(name, carrier, looks, start, max_angle)


def _bound_considered(model: FilterModel) -> Iterator[tuple[str, BlockBounds]]:
    """Yield the exact covariances of the considered errors, which no plan changes."""
    suite = model.suite
    diffusion, start = suite.compute_noise_density(), model.initial_covariance
    rest = suite.dynamics_matrix(np.zeros(3))
    for name in suite.considered_blocks:
        own = _list_block_states(suite, name)
        varies = own[0] < suite.n_dynamic
        decay, walk = (-rest[own[0], own[0]], diffusion[own]) if varies else (0.0, np.zeros(3))
        now = propagate_unobserved(start[np.ix_(own, own)], decay, walk, model.times)
        yield name, bounds_from_covariances(now)


def _invert_initial_covariance(model: FilterModel) -> Floats:
    """Return the inverse of the initial covariance.

    A 3 x 3 block on its diagonal is the information about a 3-vector if all other states are known.
    """
    sigma = model.initial_sigma
    return np.linalg.inv(model.initial_correlation) / np.outer(sigma, sigma)


def _list_block_states(suite: Suite, block: str) -> np.ndarray:
    return 3 * suite.blocks.index(block) + np.arange(3)


def list_relaxations(
    scenario: Scenario, model: FilterModel, information: SampleInformation
) -> tuple[str, ...]:
    """Return the relaxations of the lower bound, one line each.

    A relaxation that applies to every scenario is not listed: the bound of a 3-vector assumes that
    all other states are known.
    """
    uneven = (
        *(["gyro"] if has_axis_dependent_noise(model.suite.compute_noise_density()) else []),
        *information.anisotropic_sensors,
    )
    relaxations = [f"{name}: the noise of every axis is that of the best axis" for name in uneven]
    diodes = [each.name for each in model.suite.sensors if isinstance(each, Photodiode)]
    if diodes:
        relaxations.append(f"{', '.join(diodes)}: the Sun is in the most informative direction")
    for sensor in model.suite.sensors:
        if sensor.list_visibility_cones() and sensor.name not in diodes:
            relaxations.append(f"{sensor.name}: field of view ignored")
        if sensor.max_rate() < np.inf:
            relaxations.append(f"{sensor.name}: maximum rate ignored")
    if (model.initial_correlation != np.eye(len(model.initial_sigma))).any():
        relaxations.append("initial correlations: conditional covariance of each 3-vector")
    if model.suite.considered_indices.size:
        relaxations.append("considered errors are known in the bounds of other states")
    if len(model.suite.gyro.states()) > 1:
        relaxations.append("rate-dependent gyro errors: any attitude, at the maximum rates")
    turning = [
        ("magnetorquers" if scenario.is_magnetorquer_driven else "ramps", model.slew_limits),
        ("path constraints", model.path_constraints),
        ("wheels", scenario.wheels),
    ]
    relaxations += [f"{name}: ignored, the attitude is free" for name, value in turning if value]
    return tuple(relaxations)
