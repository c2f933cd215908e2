"""Constraints on a plan, as values that are at most zero if satisfied."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.directions import DIRECTIONS, SatelliteState
from mgeo_attitude.filter.evaluator import Evaluation
from mgeo_attitude.filter.path_constraints import compute_violation_on_orbit
from mgeo_attitude.scenario.constraints import PathConstraint
from mgeo_attitude.scenario.criteria import RequiredSigma
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.settings.errors import InvalidValue, expect

#: Label of the constraint that a plan ends before its window ends.
PLAN_END = "end of the plan"

#: Factor on limits that allows for rounding of unit conversions.
_ROUNDING_FACTOR = 1.0 + 1e-12


@dataclass(frozen=True)
class Bound:
    """Bound on a quantity of a plan.

    Attributes
    ----------
    label : str
    quantity : function
        Returns the quantity of each design, shape (n,); NaN without a result.
    value : float
        Positive bound, in the unit of the quantity.
    unit : str
        Unit for display.
    factor : float
        Factor from the unit of the quantity to the unit for display.
    is_lower : bool
        Whether the bound is a lower bound.
    """

    label: str
    quantity: Callable[[Evaluation], Floats]
    value: float
    unit: str
    factor: float = 1.0
    is_lower: bool = False

    def compute_violation(self, result: Evaluation) -> Floats:
        """Return the relative violation of the bound by each design, shape (n,).

        The violation is positive if the bound is violated.
        """
        share = self.quantity(result) / self.value
        return 1.0 - share if self.is_lower else share - 1.0


@dataclass(frozen=True)
class Constraint:
    """Constraint of the scenario that consists of one or more bounds.

    Attributes
    ----------
    label : str
    bounds : tuple of Limit
    needs_covariance : bool
        Whether the evaluation must contain the covariances at the end.
    """

    label: str
    bounds: tuple[Bound, ...]
    needs_covariance: bool = False

    def compute_violations(self, result: Evaluation) -> Floats:
        """Return the relative violation of each bound by n designs, shape (n_limits, n).

        The value of the constraint is the largest one. A design without a result has NaN.
        """
        return np.array([limit.compute_violation(result) for limit in self.bounds])


def list_constraints(scenario: Scenario) -> list[Constraint]:
    """Return the constraints of a scenario, in a fixed order."""
    limits, wheels = [], scenario.wheels
    if wheels is not None and wheels.max_momentum is not None:
        momentum = partial(
            _compute_max_wheel_momentum,
            inertia=wheels.inertia_matrix(),
            allocation=wheels.compute_load_matrix(),
        )
        load = (lambda result: result.wheel_load[:, 0]) if wheels.has_momentum_budget else momentum
        limits.append(Bound("wheel momentum", load, wheels.max_momentum, "N m s"))
    if wheels is not None and wheels.max_torque is not None and wheels.has_momentum_budget:
        torque = wheels.max_torque
        limits.append(Bound("wheel torque", lambda result: result.wheel_load[:, 1], torque, "N m"))
    if scenario.windows:  # `view.margins` checks the slew back.
        limits.append(Bound(PLAN_END, lambda result: result.t_end, scenario.deadline, "s"))
    result = [Constraint(limit.label, (limit,)) for limit in limits]
    result += [
        _build_path_constraint(i, limit) for i, limit in enumerate(scenario.path_constraints)
    ]
    if scenario.required_sigma:
        result.append(_build_required_sigma(scenario))
    return result


def validate_initial_state(scenario: Scenario) -> None:
    """Raise InvalidValue if the initial state of a scenario violates a constraint.

    No plan can satisfy such a scenario, because the initial attitude and rate are given.

    Raises
    ------
    InvalidValue
        If the initial rate exceeds the maximum rate of maneuvers or the momentum of a wheel, or a
        path constraint is violated, including its margin.
    """
    initial = scenario.initial
    moving = initial.rate_deg_s is not None or initial.pointing != "inertial"
    if not (moving or scenario.prior is not None or scenario.path_constraints):
        return
    at = SatelliteState.from_times(scenario, np.zeros(1))
    at = at if scenario.eclipse else at.without_eclipses()
    _validate_initial_rate(scenario, scenario.compute_initial_rate(at))
    _validate_initial_attitude(scenario, at)


def _validate_initial_rate(scenario: Scenario, rate: Floats) -> None:
    key: str = "initial.pointing"
    value: object = scenario.initial.pointing
    for section in ("initial", "prior"):
        given = getattr(getattr(scenario, section), "rate_deg_s", None)
        key, value = (key, value) if given is None else (f"{section}.rate_deg_s", given)
    most, about = scenario.maneuvers.max_rate_deg_s, np.abs(np.degrees(rate))
    worst = int(about.argmax())
    expected = (
        f"at most maneuvers.max_rate_deg_s = {most!r} about each axis, not {about[worst]:.6g} "
        f"about {'xyz'[worst]}"
    )
    expect(about[worst] <= most * _ROUNDING_FACTOR, key, value, expected)
    wheels = scenario.wheels
    if wheels is None or wheels.max_momentum is None or wheels.initial_momentum:
        return
    momentum = wheels.compute_largest_load(rate @ wheels.inertia_matrix())
    expected = (
        f"at most wheels.max_momentum = {wheels.max_momentum!r} N m s in each wheel, not "
        f"{momentum:.6g}"
    )
    expect(momentum <= wheels.max_momentum * _ROUNDING_FACTOR, key, value, expected)


def _validate_initial_attitude(scenario: Scenario, state: SatelliteState) -> None:
    attitude, known = scenario.compute_initial_attitude(state), scenario.initial_attitude_covariance
    still = np.zeros((1, 3))
    sigma_deg = scenario.initial.attitude_deg
    if scenario.prior is not None:
        sigma_deg = float(np.degrees(scenario.prior.sigma[:3].max()))
    for i, limit in enumerate(scenario.path_constraints):
        cone, half_angle = limit.build_cone(), limit.half_angle_deg
        sign, most, less = (1.0, "least", "and") if cone.keep_in else (-1.0, "most", "less")
        angle, bound = (
            sign
            * np.degrees(
                compute_violation_on_orbit(
                    cone, k, state, scenario.epoch, attitude[None], still, known[None]
                )[0]
            )
            for k in (0.0, limit.attitude_sigmas)
        )
        if half_angle < bound if cone.keep_in else half_angle > bound:
            other = f"at {most} {bound:.4g}, or " if 0.0 < bound < 180.0 else ""
            raise InvalidValue(
                f"path_constraints[{i}].half_angle_deg",
                half_angle,
                f"expected {other}another attitude in [initial]: at the start "
                f"{DIRECTIONS[cone.direction].label} is {angle:.4g} deg from the boresight of "
                f"{limit.name!r}, {less} attitude_sigmas = {limit.attitude_sigmas:g} of "
                f"initial.attitude_deg = {sigma_deg:g}",
            )


def _compute_max_wheel_momentum(result: Evaluation, inertia: Floats, allocation: Floats) -> Floats:
    """Return the largest wheel momentum [N m s], shape (n,), for zero total momentum."""
    # Rates change linearly in a ramp, so the momentum is largest at an end of one of its steps.
    momentum = np.abs(result.plan.end_rates @ inertia @ allocation.T).max(axis=2)
    greatest: Floats = np.where(result.plan.has_duration(), momentum, 0.0).max(axis=1)
    return greatest


def _build_path_constraint(index: int, constraint: PathConstraint) -> Constraint:
    sigmas, sign = constraint.attitude_sigmas, "and" if constraint.keep_in else "less"
    angle = Bound(
        f"{constraint.label} {sign} {sigmas:g} sigma" if sigmas else constraint.label,
        lambda result: result.path_angle[:, index],
        np.radians(constraint.half_angle_deg),
        "deg",
        float(np.degrees(1.0)),
        is_lower=not constraint.keep_in,
    )
    return Constraint(constraint.label, (angle,))


def _build_required_sigma(scenario: Scenario) -> Constraint:
    suite = scenario.suite
    required = RequiredSigma(scenario.required_sigma).list_sigmas(suite.units)
    limits = (
        Bound(
            f"required 1-sigma of {unit.label}",
            partial(_compute_worst_sigma, index=index),
            greatest,
            unit.unit,
            unit.factor,
        )
        for index, (greatest, unit) in enumerate(
            zip(required, list_block_units(suite), strict=True)
        )
        if greatest < np.inf
    )
    return Constraint("required 1-sigma", tuple(limits), needs_covariance=True)


def _compute_worst_sigma(result: Evaluation, index: int) -> Floats:
    variances = np.diagonal(result.covariance, axis1=1, axis2=2)
    worst: Floats = np.sqrt(variances[:, 3 * index : 3 * index + 3]).max(axis=1)
    return worst
