"""What a plan must keep, as values that are at most zero where it does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.describe import block_units
from mgeo_attitude.fields import expect
from mgeo_attitude.filter.keep_out import sun_clearance
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.suite import Suite
from mgeo_attitude.scenario.settings import RequiredSigma

if TYPE_CHECKING:
    from mgeo_attitude.environment.pointing import Place
    from mgeo_attitude.filter.evaluator import Evaluation
    from mgeo_attitude.scenario import KeepOut, Scenario


@dataclass(frozen=True)
class Limit:
    """A number that a plan must not exceed or, with `least`, not fall below.

    `measured` is that of each design, shape (n,), NaN for one without result; the `bound` above 0
    is in its unit. It is shown in `unit`, to which `factor` leads.
    """

    label: str
    measured: Callable[[Evaluation], Floats]
    bound: float
    unit: str
    factor: float = 1.0
    least: bool = False

    def excess(self, result: Evaluation) -> Floats:
        """By how much each design violates it, as a fraction of the bound, shape (n,)."""
        share = self.measured(result) / self.bound
        return 1.0 - share if self.least else share - 1.0


@dataclass(frozen=True)
class Constraint:
    """Limits of the scenario, at least one, that are kept or violated as one.

    Where it `needs_covariance`, the evaluation must contain the covariances at the end.
    """

    label: str
    limits: tuple[Limit, ...]
    needs_covariance: bool = False

    def value(self, model: FilterModel, result: Evaluation) -> Floats:
        """Greatest excess over its limits, shape (n,); NaN for a design without result."""
        greatest: Floats = np.max([limit.excess(result) for limit in self.limits], axis=0)
        return greatest


def constraints(scenario: Scenario) -> list[Constraint]:
    """Constraints that a scenario asks for, in a fixed order."""
    found = []
    wheels = scenario.wheels
    if wheels is not None and wheels.max_momentum is not None:
        momentum = partial(_wheel_momentum, inertia=wheels.matrix())
        limit = Limit("wheel momentum", momentum, wheels.max_momentum, "N m s")
        found.append(Constraint(limit.label, (limit,)))
    found += [_keep_out(i, cone) for i, cone in enumerate(scenario.keep_outs)]
    if scenario.required_sigma:
        found.append(_required_sigma(scenario))
    return found


def check_start(scenario: Scenario) -> None:
    """Refuse limits that no plan keeps, because the attitude and the rate at the start are given.

    Raises
    ------
    InvalidValue
        For a rate above that of maneuvers or the momentum of wheels, or a keep-out cone that the
        Sun is in, or within the margin of.
    """
    initial = scenario.initial
    moving = initial.rate_deg_s is not None or initial.pointing != "inertial"
    if moving or scenario.prior is not None or scenario.keep_outs:
        from mgeo_attitude.environment.pointing import Place  # imports scipy

        at = Place.at(scenario, np.zeros(1))
        _check_rate(scenario, scenario.initial_rate(at))
        _check_cones(scenario, at)


def _check_rate(scenario: Scenario, rate: Floats) -> None:
    key: str = "initial.pointing"
    value: object = scenario.initial.pointing
    for section in ("initial", "prior"):
        given = getattr(getattr(scenario, section), "rate_deg_s", None)
        key, value = (key, value) if given is None else (f"{section}.rate_deg_s", given)
    wheels = scenario.wheels
    limits = [("maneuvers.max_rate_deg_s", scenario.maneuvers.max_rate_deg_s, np.degrees(rate))]
    if wheels is not None and wheels.max_momentum is not None:
        limits.append(("wheels.max_momentum", wheels.max_momentum, wheels.matrix() @ rate))
    for name, most, found in limits:
        worst = int(np.abs(found).argmax())
        expected = (
            f"at most {name} = {most!r} about each axis, not {abs(found[worst]):.6g} about "
            f"{'xyz'[worst]}"
        )
        expect(abs(found[worst]) <= most * (1.0 + 1e-12), key, value, expected)


def _check_cones(scenario: Scenario, at: Place) -> None:
    if scenario.eclipse and not at.sunlit[0]:
        return
    sun = at.sun @ scenario.initial_attitude(at).T
    covariance = scenario.initial_attitude_covariance[None]
    sigma_deg = scenario.initial.attitude_deg
    if scenario.prior is not None:
        sigma_deg = float(np.degrees(scenario.prior.sigma[:3].max()))
    for i, cone in enumerate(scenario.keep_outs):
        axis = np.array(cone.axis())
        angle, clearance = (
            np.degrees(sun_clearance(axis, k, sun, covariance)[0])
            for k in (0.0, cone.attitude_sigmas)
        )
        smaller = f"at most {clearance:.4g}, or " if clearance > 0.0 else ""
        expected = (
            f"{smaller}another attitude in [initial]: at the start the Sun is {angle:.4g} deg from "
            f"the boresight of {cone.name}, and the margin is attitude_sigmas = "
            f"{cone.attitude_sigmas:g} times initial.attitude_deg = {sigma_deg:g}"
        )
        key, kept = f"keep_outs[{i}].half_angle_deg", cone.half_angle_deg <= clearance
        expect(kept, key, cone.half_angle_deg, expected)


def _wheel_momentum(result: Evaluation, inertia: Floats) -> Floats:
    """Greatest momentum about a body axis that the wheels hold [N m s], shape (n,)."""
    # a ramp is straight, so the greatest momentum is at an end of one of its steps
    momentum = np.abs(result.plan.end_rates @ inertia).max(axis=2)
    greatest: Floats = np.where(result.plan.flown(), momentum, 0.0).max(axis=1)
    return greatest


def _keep_out(index: int, cone: KeepOut) -> Constraint:
    label, sigmas = f"Sun off {cone.name}", cone.attitude_sigmas
    limit = Limit(
        f"{label} less {sigmas:g} sigma" if sigmas else label,
        lambda result: result.sun_angle[:, index],
        np.radians(cone.half_angle_deg),
        "deg",
        float(np.degrees(1.0)),
        least=True,
    )
    return Constraint(label, (limit,))


def _required_sigma(scenario: Scenario) -> Constraint:
    """Of the worst axis of each 3-vector of the state."""
    suite = Suite(scenario.gyro, scenario.sensors)
    required = RequiredSigma(scenario.required_sigma).of(suite.units)
    limits = (
        Limit(
            f"required 1-sigma of {unit.label}",
            partial(_worst_sigma, index=index),
            greatest,
            unit.unit,
            unit.factor,
        )
        for index, (greatest, unit) in enumerate(zip(required, block_units(suite), strict=True))
        if greatest < np.inf
    )
    return Constraint("required 1-sigma", tuple(limits), needs_covariance=True)


def _worst_sigma(result: Evaluation, index: int) -> Floats:
    variances = np.diagonal(result.covariance, axis1=1, axis2=2)
    worst: Floats = np.sqrt(variances[:, 3 * index : 3 * index + 3]).max(axis=1)
    return worst
