"""Inputs of the wheel-load computation that do not depend on the plan."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.scenario.actuators import pseudo_inverse_allocation
from mgeo_attitude.scenario.scenario import Scenario


@dataclass(frozen=True)
class MomentumBudget:
    """Inputs of the wheel-load computation that do not depend on the maneuvers.

    Attributes
    ----------
    inertia : array, shape (3, 3)
        Inertia of the satellite [kg m²].
    allocation : array, shape (k, 3)
        Momentum of each wheel per momentum of the satellite, see `Wheels.compute_load_matrix`.
    null_space_momentum : array, shape (k,)
        Initial wheel momenta in the null space of the wheel axes, with zero vector sum [N m s].
    attitude : array, shape (3, 3)
        GCRS-to-body matrix at the start.
    rate : array, shape (3,)
        Body rate at the start [rad/s].
    momentum : array, shape (3,)
        Angular momentum of the satellite at the start, GCRS [N m s].
    position, field : arrays, shape (n_steps + 1, 3)
        Position of the satellite [m] and geomagnetic field [T], GCRS.
    residual_dipole : array, shape (3,)
        Residual dipole, body axes [A m²].
    gravity_gradient : float
        1 to include the gravity-gradient torque, 0 otherwise.
    disturbance_margin : float
        Factor on the disturbance torques.
    magnetorquer_dipole : array, shape (3,)
        Largest mean dipole of a step for unloading, per axis [A m²]; zero without unloading.
    unloading_time_constant : float
        Time constant of unloading without saturation [s].
    """

    inertia: Floats
    allocation: Floats
    null_space_momentum: Floats
    attitude: Floats
    rate: Floats
    momentum: Floats
    position: Floats
    field: Floats
    residual_dipole: Floats
    gravity_gradient: float
    disturbance_margin: float
    magnetorquer_dipole: Floats
    unloading_time_constant: float

    @classmethod
    def from_scenario(
        cls, scenario: Scenario, environment: Environment, attitude: Floats, rate: Floats
    ) -> MomentumBudget | None:
        """Build the momentum budget of a scenario, or return None if none is needed.

        No budget is needed if the wheel loads follow from the body rates alone.

        Parameters
        ----------
        scenario : Scenario
        environment : Environment
        attitude, rate : arrays
            Initial GCRS-to-body matrix, shape (3, 3), and body rate [rad/s], shape (3,).
        """
        wheels, magnetorquers = scenario.wheels, scenario.magnetorquers
        if wheels is None or not wheels.has_momentum_budget:
            return None
        unloading_dipole, time_constant = np.zeros(3), np.inf
        if magnetorquers is not None and magnetorquers.unloads_wheels:
            unloading_dipole, time_constant = (
                magnetorquers.duty_cycle * np.array(magnetorquers.max_dipole),
                magnetorquers.time_constant,
            )
        axes = wheels.normalized_axes()
        allocation, inertia = wheels.compute_load_matrix(), wheels.inertia_matrix()
        wheel_momentum, momentum = np.zeros(len(axes)), np.zeros(3)
        if wheels.initial_momentum:  # By default the total momentum is zero.
            wheel_momentum = np.array(wheels.initial_momentum)
            momentum = axes.T @ wheel_momentum + inertia @ rate
        null_space_momentum = np.zeros(len(allocation))
        if wheels.allocation == "pseudo-inverse":  # The minimax rule redistributes the momentum.
            null_space_momentum = wheel_momentum - pseudo_inverse_allocation(axes) @ (
                axes.T @ wheel_momentum
            )
        return cls(
            inertia=inertia,
            allocation=np.ascontiguousarray(allocation),
            null_space_momentum=null_space_momentum,
            attitude=np.ascontiguousarray(attitude),
            rate=rate,
            momentum=attitude.T @ momentum,
            position=np.ascontiguousarray(environment.position),
            field=environment.field_tesla,
            residual_dipole=np.array(wheels.residual_dipole),
            gravity_gradient=float(wheels.gravity_gradient),
            disturbance_margin=wheels.disturbance_margin,
            magnetorquer_dipole=unloading_dipole,
            unloading_time_constant=time_constant,
        )

    def rotate_initial_attitude(self, rotation: Floats) -> MomentumBudget:
        """Return a copy of the budget with a rotated initial attitude.

        The argument is that of `FilterModel.rotate_initial_attitude`.
        """
        return dataclasses.replace(
            self, position=self.position @ rotation, field=self.field @ rotation
        )
