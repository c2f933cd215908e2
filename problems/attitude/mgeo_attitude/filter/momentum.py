"""The wheels' momentum budget: what their load along a plan follows from, but for the plan."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.scenario.actuators import pseudo_inverse
from mgeo_attitude.scenario.scenario import Scenario


@dataclass(frozen=True)
class MomentumBudget:
    """What the wheels' load along a plan follows from.

    Attributes
    ----------
    inertia : array, shape (3, 3)
        [kg m²]
    allocation : array, shape (k, 3)
        See `Wheels.shares`.
    circulating : array, shape (k,)
        What of the initial momentum the allocation leaves in the wheels, without a resultant
        [N m s].
    attitude : array, shape (3, 3)
        At the start, GCRS to body.
    rate : array, shape (3,)
        Of the body at the start [rad/s].
    momentum : array, shape (3,)
        The satellite's at the start, GCRS [N m s].
    position, field : arrays, shape (n_steps + 1, 3)
        Satellite [m] and geomagnetic field [T], GCRS.
    dipole : array, shape (3,)
        Body axes [A m²].
    gradient : float
        1 if the gravity gradient counts, or else 0.
    margin : float
        Factor on what disturbances do.
    coils : array, shape (3,)
        Greatest mean dipole of a step with which they unload the wheels [A m²]; zero if they do
        not.
    response : float
        Time in which that falls by e where no coil is at its most [s].
    """

    inertia: Floats
    allocation: Floats
    circulating: Floats
    attitude: Floats
    rate: Floats
    momentum: Floats
    position: Floats
    field: Floats
    dipole: Floats
    gradient: float
    margin: float
    coils: Floats
    response: float

    @classmethod
    def of(
        cls, scenario: Scenario, environment: Environment, attitude: Floats, rate: Floats
    ) -> MomentumBudget | None:
        """That of a scenario; None where the total momentum is always zero.

        Parameters
        ----------
        attitude, rate
            At the start, see the class.
        """
        wheels, coils = scenario.wheels, scenario.coils
        if wheels is None or not wheels.budgeted:
            return None
        unloading, response = np.zeros(3), np.inf
        if coils is not None and coils.unloads:
            unloading, response = coils.duty * np.array(coils.max_dipole), coils.response
        axes = wheels.spin_axes()
        allocation, inertia = wheels.shares(), wheels.matrix()
        wheel_momentum, momentum = np.zeros(len(axes)), np.zeros(3)
        if wheels.initial_momentum:  # or else what makes the sum zero
            wheel_momentum = np.array(wheels.initial_momentum)
            momentum = axes.T @ wheel_momentum + inertia @ rate
        circulating = np.zeros(len(allocation))
        if wheels.allocation == "pseudo-inverse":  # the other rule is free to spread it
            circulating = wheel_momentum - pseudo_inverse(axes) @ (axes.T @ wheel_momentum)
        return cls(
            inertia=inertia,
            allocation=np.ascontiguousarray(allocation),
            circulating=circulating,
            attitude=np.ascontiguousarray(attitude),
            rate=rate,
            momentum=attitude.T @ momentum,
            position=np.ascontiguousarray(environment.position),
            field=environment.field_tesla,
            dipole=np.array(wheels.residual_dipole),
            gradient=float(wheels.gravity_gradient),
            margin=wheels.disturbance_margin,
            coils=unloading,
            response=response,
        )

    def turned(self, turn: Floats) -> MomentumBudget:
        """See `FilterModel.turned`."""
        return dataclasses.replace(self, position=self.position @ turn, field=self.field @ turn)
