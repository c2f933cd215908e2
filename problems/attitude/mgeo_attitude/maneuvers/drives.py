"""What turns a satellite: ramps between body rates, or coils.

Of coils, what is flown is not what is asked for: they drive the body to the rates of a plan, then
it moves freely. At each filter step whose maneuver's rate has not been
reached yet, the dipole is that of the cross-product law

    m = b × τ / |b|²,   τ = ω × J ω - J (ω - ω_plan) / T,

of which no component is greater than its coil gives: else all are smaller alike. Its torque m × b
is the part of τ across the field b. (Stickler and Alfriend, Elementary Magnetic Attitude Control
System, Journal of Spacecraft and Rockets 13 (1976) 282-287; the first term takes out what turns
an axis that is not principal.) The dipole is held for a step, and the body moves by Euler's
equations J dω/dt = m × b - ω × J ω. Once the rate is within the detumble rate of the plan's, the
coils are off until the next maneuver.

Neglected: gravity gradient, drag and radiation pressure; that a coil is off for a part of each step
(its dipole is the mean); errors of gyro and magnetometer in the law; and how the field changes
within a step but for its mean.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

import numpy as np

from mgeo_attitude._typing import Bools, Floats, Ints


@dataclass(frozen=True)
class SlewLimits:
    """How fast body rates can change.

    Attributes
    ----------
    max_acceleration : float
        Greatest angular acceleration about each body axis [rad/s²]; may be infinite.
    max_torque : float
        Greatest torque of a wheel, of what ramps use [N m]; may be infinite.
    inertia : array, shape (3, 3)
        [kg m²]
    allocation : array, shape (k, 3)
        How wheels share a torque; see `Wheels.shares`.
    initial_rate : array, shape (3,)
        Body rate that the first ramp leaves [rad/s].
    """

    max_acceleration: float
    max_torque: float
    inertia: Floats
    allocation: Floats = field(default_factory=lambda: np.eye(3))
    initial_rate: Floats = field(default_factory=lambda: np.zeros(3))

    def ramp_time(self, change: Floats) -> Floats:
        """Least time [s] for changes of the rate, shape (..., 3) [rad/s], equation (12).

        The rate changes along a straight line, by the torque J dω/dt.
        """
        acceleration = np.abs(change).max(axis=-1) / self.max_acceleration
        torque = np.abs(change @ self.inertia @ self.allocation.T).max(axis=-1) / self.max_torque
        longest: Floats = np.maximum(acceleration, torque)
        return longest


@dataclass(frozen=True)
class CoilDrive:
    """What the motion of a satellite with coils alone follows from, but for the plan.

    Attributes
    ----------
    inertia : array, shape (3, 3)
        [kg m²]
    max_dipole : array, shape (3,)
        Greatest mean dipole of a step about each body axis [A m²].
    residual_dipole : array, shape (3,)
        Always there, body axes [A m²].
    near : float
        How near to the plan's rate the coils are off [rad/s].
    response : float
        T [s].
    field : array, shape (n_steps + 1, 3)
        Geomagnetic field [T], GCRS.
    initial_attitude : array, shape (3, 3)
        GCRS to body.
    initial_rate : array, shape (3,)
        Of the body [rad/s].
    """

    inertia: Floats
    max_dipole: Floats
    residual_dipole: Floats
    near: float
    response: float
    field: Floats
    initial_attitude: Floats
    initial_rate: Floats

    def turned(self, turn: Floats) -> CoilDrive:
        """See `FilterModel.turned`."""
        return dataclasses.replace(self, field=self.field @ turn)

    def rates(
        self, rates: Floats, starts: Ints, step: float, n_steps: int
    ) -> tuple[Floats, Floats, Bools]:
        """What is flown of maneuvers in `n_steps` steps, or as many as the field is known for.

        Parameters
        ----------
        rates : array, shape (n, m, 3)
            That are asked for [rad/s].
        starts : array, shape (n, m)
            First step of each; one that starts with the next is not flown.

        Returns
        -------
        mean, end : arrays, shape (n, k, 3)
            Body rate that turns the body as each step does, and that at its end [rad/s].
        free : array of bool, shape (n, k)
            Whether the coils are off.
        """
        from mgeo_attitude.maneuvers.rigid_body import driven  # compiles

        shape = len(rates), min(n_steps, len(self.field) - 1)
        mean, end = np.zeros((*shape, 3)), np.zeros((*shape, 3))
        free = np.zeros(shape, dtype=np.bool_)
        body = self.inertia, np.linalg.inv(self.inertia), self.initial_attitude, self.initial_rate
        law = self.max_dipole, self.residual_dipole, self.near, self.response
        plan = np.ascontiguousarray(rates), np.ascontiguousarray(starts)
        driven(body, law, self.field, plan, step, mean, end, free)
        return mean, end, free
