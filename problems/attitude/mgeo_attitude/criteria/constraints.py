"""Constraints on a plan, as relative violations that are positive if a constraint is violated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.directions import DIRECTIONS, SatelliteState
from mgeo_attitude.filter.evaluator import Evaluation
from mgeo_attitude.filter.path_constraints import compute_monitored_angle_on_orbit
from mgeo_attitude.scenario.constraints import PathConstraint
from mgeo_attitude.scenario.criteria import RequiredSigma
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.settings.errors import InvalidValue, expect

#: Label of the constraint that a plan ends before its time window closes.
PLAN_END = "end of the plan"

#: Factor on bounds, to tolerate rounding of unit conversions.
_ROUNDING_FACTOR = 1.0 + 1e-12


@dataclass(frozen=True)
class Bound:
    """Upper or lower bound on a quantity of a plan, such as the wheel momentum.

    Attributes
    ----------
    label : str
        Name for display.
    quantity : function of Evaluation
        Function that returns the quantity of each design, shape (n,); NaN for a design without a
        result.
    value : float
        Bound, which is positive, in the unit of the quantity.
    unit : str
        Unit for display.
    factor : float
        Factor from the unit of the quantity to the unit for display.
    is_lower : bool
        Whether the bound is a lower bound; otherwise an upper bound.
    """

    label: str
    quantity: Callable[[Evaluation], Floats]
    value: float
    unit: str
    factor: float = 1.0
    is_lower: bool = False

    def compute_violation(self, result: Evaluation) -> Floats:
        """Compute the relative violation of the bound by each of n designs, shape (n,).

        The violation is positive if the bound is violated. The violation is the excess over the
        bound, divided by the bound.
        """
        share = self.quantity(result) / self.value
        return 1.0 - share if self.is_lower else share - 1.0


@dataclass(frozen=True)
class Constraint:
    """Constraint of a scenario: one or more bounds that every plan must satisfy.

    Attributes
    ----------
    label : str
        Name for display.
    bounds : tuple of Bound
        Bounds that must all be satisfied.
    needs_covariance : bool
        Whether the evaluation must contain the covariances at the end.
    """

    label: str
    bounds: tuple[Bound, ...]
    needs_covariance: bool = False

    def compute_violations(self, result: Evaluation) -> Floats:
        """Compute the relative violation of each bound by each of n designs, shape (n_bounds, n).

        The violation is positive if the bound is violated. The constraint value of a design is the
        largest violation. A design without a result has NaN.
        """
        return np.array([bound.compute_violation(result) for bound in self.bounds])


def list_constraints(scenario: Scenario) -> list[Constraint]:
    """List the constraints of a scenario, such as wheel loads and path constraints.

    The order is: wheel loads, latest end of the plan, path constraints, required 1-sigmas.
    """
    single_bounds, wheels = [], scenario.wheels
    if wheels is not None and wheels.max_momentum is not None:
        momentum = partial(
            _compute_max_wheel_momentum,
            inertia=wheels.inertia_matrix(),
            allocation=wheels.compute_load_matrix(),
        )
        load = (lambda result: result.wheel_load[:, 0]) if wheels.has_momentum_budget else momentum
        single_bounds.append(Bound("wheel momentum", load, wheels.max_momentum, "N m s"))
    if wheels is not None and wheels.max_torque is not None and wheels.has_momentum_budget:
        torque = wheels.max_torque
        single_bounds.append(
            Bound("wheel torque", lambda result: result.wheel_load[:, 1], torque, "N m")
        )
    if scenario.windows:  # The time after `t_end` is checked in `view.margins`.
        single_bounds.append(Bound(PLAN_END, lambda result: result.t_end, scenario.deadline, "s"))
    result = [Constraint(bound.label, (bound,)) for bound in single_bounds]
    result += [
        _build_path_constraint(i, constraint)
        for i, constraint in enumerate(scenario.path_constraints)
    ]
    if scenario.required_sigma:
        result.append(_build_required_sigma(scenario))
    return result


def validate_initial_state(scenario: Scenario) -> None:
    """Raise InvalidValue if the initial attitude or rate of a scenario violates a constraint.

    No plan can satisfy such a scenario, because the initial attitude and rate are fixed.

    Raises
    ------
    InvalidValue
        If the initial rate exceeds the maximum rate of maneuvers or the maximum momentum of a
        wheel, or if a path constraint with its margin is violated.
    """
    initial = scenario.initial
    is_moving = initial.rate_deg_s is not None or initial.pointing != "inertial"
    if not (is_moving or scenario.prior is not None or scenario.path_constraints):
        return
    state = SatelliteState.from_times(scenario, np.zeros(1))
    state = state if scenario.eclipse else state.without_eclipses()
    _validate_initial_rate(scenario, scenario.compute_initial_rate(state))
    _validate_initial_attitude(scenario, state)


def _validate_initial_rate(scenario: Scenario, rate: Floats) -> None:
    key: str = "initial.pointing"
    value: object = scenario.initial.pointing
    for section in ("initial", "prior"):
        rate_deg_s = getattr(getattr(scenario, section), "rate_deg_s", None)
        key, value = (key, value) if rate_deg_s is None else (f"{section}.rate_deg_s", rate_deg_s)
    max_rate, axis_rates = scenario.maneuvers.max_rate_deg_s, np.abs(np.degrees(rate))
    worst = int(axis_rates.argmax())
    expected = (
        f"at most maneuvers.max_rate_deg_s = {max_rate!r} about each axis, not "
        f"{axis_rates[worst]:.6g} about {'xyz'[worst]}"
    )
    expect(axis_rates[worst] <= max_rate * _ROUNDING_FACTOR, key, value, expected)
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
    attitude, covariance = (
        scenario.compute_initial_attitude(state),
        scenario.initial_attitude_covariance,
    )
    rotation_vectors = np.zeros((1, 3))
    sigma_deg = scenario.initial.attitude_deg
    if scenario.prior is not None:
        sigma_deg = float(np.degrees(scenario.prior.sigma[:3].max()))
    for i, constraint in enumerate(scenario.path_constraints):
        cone, half_angle = constraint.build_cone(), constraint.half_angle_deg
        sign, bound_text, margin_text = (
            (1.0, "least", "plus") if cone.keep_in else (-1.0, "most", "minus")
        )
        angle, bound = (
            sign
            * np.degrees(
                compute_monitored_angle_on_orbit(
                    cone,
                    k,
                    state,
                    scenario.epoch,
                    attitude[None],
                    rotation_vectors,
                    covariance[None],
                )[0]
            )
            for k in (0.0, constraint.attitude_sigmas)
        )
        if half_angle < bound if cone.keep_in else half_angle > bound:
            alternative = f"at {bound_text} {bound:.4g}, or " if 0.0 < bound < 180.0 else ""
            raise InvalidValue(
                f"path_constraints[{i}].half_angle_deg",
                half_angle,
                f"expected {alternative}another attitude in [initial]: at the start "
                f"{DIRECTIONS[cone.direction].label} is {angle:.4g} deg from the boresight of "
                f"{constraint.name!r}, {margin_text} attitude_sigmas = "
                f"{constraint.attitude_sigmas:g} of initial.attitude_deg = {sigma_deg:g}",
            )


def _compute_max_wheel_momentum(result: Evaluation, inertia: Floats, allocation: Floats) -> Floats:
    """Return the largest wheel momentum [N m s] of each design, shape (n,).

    The total angular momentum is assumed to be zero.
    """
    # Rates change linearly during a ramp, so that the momentum is largest at an end of a step.
    momentum = np.abs(result.plan.end_rates @ inertia @ allocation.T).max(axis=2)
    largest: Floats = np.where(result.plan.has_duration(), momentum, 0.0).max(axis=1)
    return largest


def _build_path_constraint(index: int, constraint: PathConstraint) -> Constraint:
    angle = Bound(
        constraint.bound_label,
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
    bounds = (
        Bound(
            f"1-sigma of {unit.label}",
            partial(_compute_worst_sigma, index=index),
            sigma,
            unit.unit,
            unit.factor,
        )
        for index, (sigma, unit) in enumerate(zip(required, list_block_units(suite), strict=True))
        if sigma < np.inf
    )
    return Constraint("required 1-sigma", tuple(bounds), needs_covariance=True)


def _compute_worst_sigma(result: Evaluation, index: int) -> Floats:
    variances = np.diagonal(result.covariance, axis1=1, axis2=2)
    worst: Floats = np.sqrt(variances[:, 3 * index : 3 * index + 3]).max(axis=1)
    return worst
