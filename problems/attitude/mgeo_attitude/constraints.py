"""What a plan must keep, as values that are at most zero where it does."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .filter.evaluator import Evaluation
from .filter.keep_out import sun_clearance
from .filter.model import FilterModel
from .filter.timeline import Schedule

if TYPE_CHECKING:
    from .scenario import KeepOut, Scenario

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Constraint:
    """A limit of the scenario.

    Attributes
    ----------
    label : str
    value : function of model, designs and their evaluation
        Excess over the limit as a fraction of it, shape (n,); NaN for a design without result.
    needs_covariance : bool
        Whether the evaluation must contain the covariances at the end.
    """

    label: str
    value: Callable[[FilterModel, Floats, Evaluation], Floats]
    needs_covariance: bool = False


def constraints(scenario: Scenario) -> list[Constraint]:
    """Constraints that a scenario asks for, in a fixed order."""
    found = []
    if scenario.wheels is not None and scenario.wheels.max_momentum is not None:
        found.append(_wheel_momentum(scenario.wheels.matrix(), scenario.wheels.max_momentum))
    found += [_keep_out(i, cone) for i, cone in enumerate(scenario.keep_outs)]
    if scenario.required_sigma:
        found.append(Constraint("required 1-sigma", _required_sigma, needs_covariance=True))
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


def wheel_momentum(plan: Schedule, inertia: Floats) -> Floats:
    """Greatest momentum about a body axis that the wheels hold [N m s], shape (n,)."""
    momentum = np.abs(plan.rates @ inertia).max(axis=2)
    greatest: Floats = np.where(plan.flown(), momentum, 0.0).max(axis=1)
    return greatest


def _wheel_momentum(inertia: Floats, limit: float) -> Constraint:
    def value(model: FilterModel, designs: Floats, result: Evaluation) -> Floats:
        return wheel_momentum(result.plan, inertia) / limit - 1.0

    return Constraint("wheel momentum", value)


def _keep_out(index: int, cone: KeepOut) -> Constraint:
    half_angle = np.radians(cone.half_angle_deg)

    def value(model: FilterModel, designs: Floats, result: Evaluation) -> Floats:
        excess: Floats = 1.0 - result.sun_angle[:, index] / half_angle
        return excess

    return Constraint(f"Sun off {cone.name}", value)


def _required_sigma(model: FilterModel, designs: Floats, result: Evaluation) -> Floats:
    sigma = np.sqrt(np.diagonal(result.covariance, axis1=1, axis2=2))
    worst: Floats = (sigma / model.required_sigma).max(axis=1) - 1.0
    return worst
