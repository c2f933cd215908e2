"""Lower bound of the covariance over all plans of a scenario, and the relaxations behind the bound.

The docstrings cite equations (2) to (11) of docs/explanation/lower-bound.md.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.lower_bound.common_mode import InertialErrorDynamics, bound_common_modes
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
    """Compute lower bounds on the filter covariance that hold for every plan of a scenario.

    The bounds are functions of time. At each time the bound holds for every attitude history whose
    body rates are within the limits of the maneuvers, or at any rate with magnetorquer control.
    Plans are executed without errors.

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
    >>> from mgeo_attitude import Scenario, compute_lower_bound
    >>> bound = compute_lower_bound(Scenario.paper())
    >>> bound.trace[[600, 1800]].round(8)
    array([1.919e-05, 6.100e-06])
    """
    model = FilterModel.from_scenario(scenario) if model is None else model
    return _assemble_lower_bound(scenario, model, collect_information(model))


def _assemble_lower_bound(
    scenario: Scenario, model: FilterModel, information: SampleInformation
) -> LowerBound:
    initial_information = _invert_initial_covariance(model)
    max_rate = np.radians(scenario.maneuvers.max_rate_deg_s)
    max_rates = np.maximum(max_rate, np.abs(model.initial_rate))
    bounds = dict(_bound_inertial(model, information, initial_information))
    is_rate_free = scenario.is_magnetorquer_driven  # Magnetorquers do not limit the rate.
    bounds |= dict(_bound_gyro(model, information, initial_information, max_rates, is_rate_free))
    bounds |= dict(_bound_sensors(model, information, initial_information))
    max_angle = np.pi if is_rate_free else float(np.linalg.norm(max_rates)) * model.step
    for name, variance_sum in _bound_common_modes(
        model, information, initial_information, max_angle
    ):
        bounds[name] = bounds[name].raise_to_sum(variance_sum)
    bounds |= dict(_bound_considered(model))
    return assemble_bounds(scenario, model, bounds, list_relaxations(scenario, model, information))


def _bound_inertial(
    model: FilterModel, information: SampleInformation, initial_information: Floats
) -> Iterator[tuple[str, BlockBounds]]:
    """Yield the name and the covariance bounds of each error that is fixed in inertial axes, such
    as the attitude error.

    The bounds follow from a covariance recursion with the joint information of all sensors. See
    equation (4) of docs/explanation/lower-bound.md.
    """
    suite, names = model.suite, information.inertial_blocks
    indices = np.concatenate([_list_block_states(suite, name) for name in names])
    axes = np.eye(len(indices))
    axes[:3, :3] = model.initial_attitude
    start = np.linalg.inv(axes.T @ initial_information[np.ix_(indices, indices)] @ axes)
    walk_variances = suite.compute_noise_density()[:3] * model.step
    decay, noise = np.repeat([(1.0, walk_variances.min())], 3 * len(names), axis=0).T
    for i, name in enumerate(names[1:], start=1):
        states = slice(3 * i, 3 * i + 3)
        decay[states], noise[states] = suite.processes[name].discretize(model.step)
    covariances = run_covariance_recursion(start, decay, noise, information.joint)
    for i, name in enumerate(names):
        states = slice(3 * i, 3 * i + 3)
        block = bounds_from_covariances(covariances[:, states, states])
        if name == "attitude":  # The body axes may have equal shares of the variance.
            block = block._replace(max_variance=block.variance_sum / 3.0)
            if information.anisotropic_sensors or np.ptp(walk_variances):
                block = block.combine_with(
                    _bound_by_mean(
                        information.attitude_trace,
                        initial_information[:3, :3],
                        1.0,
                        harmonic_mean(walk_variances),
                    )
                )
        yield name, block


def _bound_by_mean(
    traces: Floats, initial_information: Floats, decay: float, noise: float
) -> BlockBounds:
    """Compute lower bounds on the covariance of a state block from the trace of its measured
    information.

    A scalar covariance recursion bounds the mean eigenvalue of the information matrix. See equation
    (9) of docs/explanation/lower-bound.md.
    """
    start = np.array([[3.0 / np.trace(initial_information)]])
    variances = run_covariance_recursion(
        start, np.array([decay]), np.array([noise]), traces[:, None, None] / 3.0
    )
    return bounds_from_eigenvalues(np.repeat(variances[:, 0], 3, axis=1))


def harmonic_mean(noise_densities: Floats) -> float:
    """Return the harmonic mean of the noise densities of several axes.

    Isotropic noise of this density gives the same total information as the anisotropic noise.
    """
    return float(len(noise_densities) / np.sum(1.0 / noise_densities))


def _bound_gyro(
    model: FilterModel,
    information: SampleInformation,
    initial_information: Floats,
    max_rates: Floats,
    is_rate_free: bool,
) -> Iterator[tuple[str, BlockBounds]]:
    """Yield the name and the covariance bounds of each gyro error, such as the bias.

    See equations (6) and (7) of docs/explanation/lower-bound.md.
    """
    suite, times = Suite(model.suite.gyro, ()), model.times
    noise_densities, matrices = (
        suite.compute_noise_density(),
        np.array(list(map(suite.dynamics_matrix, rate_box_corners(max_rates)))),
    )
    attitude_information, angle_random_walk = (
        initial_information[:3, :3],
        harmonic_mean(noise_densities[:3]),
    )
    for name in suite.blocks[1:]:
        states = _list_block_states(suite, name)
        gain = float(np.linalg.norm(matrices[:, :3, states], 2, axis=(1, 2)).max())
        dynamics = GyroErrorDynamics(
            gain, -matrices[0][states[0], states[0]], noise_densities[states].min()
        )
        start = (
            np.inf
            if initial_information[:3, states].any()
            else float(np.trace(attitude_information))
        )
        block_information = initial_information[np.ix_(states, states)]
        block = bounds_from_eigenvalues(
            bound_through_attitude(
                times,
                dynamics,
                block_information,
                information.attitude_trace,
                start,
                angle_random_walk,
            )
        )
        at_any_rate = (matrices[:, :3, states] == matrices[0, :3, states]).all()
        if is_rate_free and not at_any_rate:
            raise NoLowerBoundError(
                f"{name}: no lower bound is known, because its effect on the attitude depends on "
                "the rate, which magnetorquers do not constrain"
            )
        if at_any_rate:
            variances = bound_with_known_attitude(
                times, dynamics, block_information, noise_densities[:3].min()
            )
            block = block.combine_with(bounds_from_eigenvalues(variances))
        yield name, block


def _bound_sensors(
    model: FilterModel, information: SampleInformation, initial_information: Floats
) -> Iterator[tuple[str, BlockBounds]]:
    """Yield the name and the covariance bounds of each sensor or environment error that is not
    fixed in inertial axes.

    These errors are not among `information.inertial_blocks`. All other states are assumed known.
    See equation (5) of docs/explanation/lower-bound.md.
    """
    for name, block_information in information.blocks.items():
        states = _list_block_states(model.suite, name)
        start, process = (
            initial_information[np.ix_(states, states)],
            model.suite.processes.get(name),
        )
        if process is not None:
            decay, noise = process.discretize(model.step)
            yield (
                name,
                _bound_by_mean(
                    block_information.trace, start, decay, harmonic_mean(np.broadcast_to(noise, 3))
                ),
            )
        elif block_information.matrix is not None:
            measured = np.cumsum(block_information.matrix, axis=0)
            yield name, bounds_from_covariances(np.linalg.inv(start + measured))
        else:
            yield name, bounds_from_information(start, np.cumsum(block_information.trace))


def _bound_common_modes(
    model: FilterModel,
    information: SampleInformation,
    initial_information: Floats,
    max_angle: float,
) -> Iterator[tuple[str, Floats]]:
    """Yield lower bounds on the variances of errors that measurements distinguish only if the body
    rotates.

    Each item is the name of an error and a lower bound on the sum of its three variances. The
    errors are inertial and body-fixed errors, such as the attitude error and a misalignment. See
    equation (10) of docs/explanation/lower-bound.md.
    """
    suite = model.suite
    if (model.initial_correlation != np.eye(len(initial_information))).any():
        return
    states = {name: _list_block_states(suite, name) for name in suite.blocks}
    start = {
        name: initial_information[np.ix_(indices, indices)] for name, indices in states.items()
    }
    for name in information.inertial_blocks:
        decay, noise = 1.0, suite.compute_noise_density()[:3] * model.step
        if name != "attitude":
            decay, noise = suite.processes[name].discretize(model.step)
        dynamics = InertialErrorDynamics(float(decay), float(np.min(noise)), start[name])
        observations = [
            observation
            for observation in information.inertial_errors
            if observation.inertial_error == name
        ]
        yield from bound_common_modes(name, dynamics, observations, start, max_angle)


def _bound_considered(model: FilterModel) -> Iterator[tuple[str, BlockBounds]]:
    """Yield the name and the covariance of each considered error.

    The filter does not estimate such an error, so that its covariance is exact.
    """
    suite = model.suite
    noise_density, start = suite.compute_noise_density(), model.initial_covariance
    dynamics = suite.dynamics_matrix(np.zeros(3))
    for name in suite.considered_blocks:
        states = _list_block_states(suite, name)
        is_dynamic = states[0] < suite.n_dynamic
        decay, block_density = (
            (-dynamics[states[0], states[0]], noise_density[states])
            if is_dynamic
            else (0.0, np.zeros(3))
        )
        covariances = propagate_unobserved(
            start[np.ix_(states, states)], decay, block_density, model.times
        )
        yield name, bounds_from_covariances(covariances)


def _invert_initial_covariance(model: FilterModel) -> Floats:
    sigma = model.initial_sigma
    return np.linalg.inv(model.initial_correlation) / np.outer(sigma, sigma)


def _list_block_states(suite: Suite, block: str) -> np.ndarray:
    return 3 * suite.blocks.index(block) + np.arange(3)


def list_relaxations(
    scenario: Scenario, model: FilterModel, information: SampleInformation
) -> tuple[str, ...]:
    """List the relaxations in the lower bound of a scenario, such as an ignored field of view.

    A relaxation is one line of text. Each relaxation makes the bound lower than the covariance of
    the best plan. One relaxation is common to all scenarios and is not listed: the bound of a
    3-vector assumes that all other states are known, except for a few that are bounded jointly.
    """
    anisotropic = (
        *(["gyro"] if has_axis_dependent_noise(model.suite.compute_noise_density()) else []),
        *information.anisotropic_sensors,
    )
    relaxations = [
        f"{name}: the noise of every axis is that of the best axis" for name in anisotropic
    ]
    diodes = [each.name for each in model.suite.sensors if isinstance(each, Photodiode)]
    if diodes:
        relaxations.append(f"{', '.join(diodes)}: the Sun is in the most informative direction")
    for sensor in model.suite.sensors:
        if sensor.list_visibility_cones() and sensor.name not in diodes:
            relaxations.append(f"{sensor.name}: field of view ignored")
        if sensor.get_max_rate() < np.inf:
            relaxations.append(f"{sensor.name}: maximum rate ignored")
    if (model.initial_correlation != np.eye(len(model.initial_sigma))).any():
        relaxations.append("initial correlations: conditional covariance of each 3-vector")
    if model.suite.considered_indices.size:
        relaxations.append("considered errors are known in the bounds of other states")
    if len(model.suite.gyro.states()) > 1:
        relaxations.append("rate-dependent gyro errors: any attitude, at the maximum rates")
    limits = [
        ("magnetorquers" if scenario.is_magnetorquer_driven else "ramps", model.slew_limits),
        ("path constraints", model.path_constraints),
        ("wheels", scenario.wheels),
    ]
    relaxations += [f"{name}: ignored, the attitude is free" for name, value in limits if value]
    return tuple(relaxations)
