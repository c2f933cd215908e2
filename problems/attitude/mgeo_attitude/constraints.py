"""What a plan must keep, as values that are at most zero where it does."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.describe import block_units
from mgeo_attitude.filter.keep_out import sun_clearance
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.suite import Suite
from mgeo_attitude.scenario.settings import RequiredSigma

if TYPE_CHECKING:
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


def warn_of_start(scenario: Scenario, model: FilterModel) -> None:
    """Say of keep-out cones that no plan keeps: the attitude at the start is given, and the Sun.

    Warns
    -----
    UserWarning
        For a cone that the Sun is in at the start, or within the margin of.
    """
    initial = np.diag(model.initial_sigma[:3] ** 2)[None]
    for i, (cone, axis) in enumerate(zip(scenario.keep_outs, model.cones, strict=True)):
        angle, clearance = (
            np.degrees(sun_clearance(axis, k, model.sun[:1], initial)[0])
            for k in (0.0, cone.attitude_sigmas)
        )
        if clearance < cone.half_angle_deg:
            warnings.warn(
                f"keep_outs[{i}] ({cone.name}): no plan keeps it, because at the start the Sun is "
                f"{angle:.4g} deg from the boresight, and half_angle_deg = {cone.half_angle_deg:g} "
                f"with attitude_sigmas = {cone.attitude_sigmas:g} times initial.attitude_deg = "
                f"{scenario.initial.attitude_deg:g} is more",
                stacklevel=3,
            )


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
