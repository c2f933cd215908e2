"""Actuation of the rates of a plan: ramps between body rates, or magnetorquers.

Magnetorquers only approximate the rates of a plan: they drive the body to the rate of a maneuver,
then the body rotates freely. At each filter step before the rate is reached, the dipole follows the
cross-product law

    m = b × τ / |b|²,   τ = ω × J ω - J (ω - ω_plan) / T,

with field b, body rate ω, inertia J and time constant T. The dipole is scaled down as a whole if a
component exceeds the maximum of its magnetorquer. The torque m × b is the part of τ across the
field. (Stickler and Alfriend, Elementary Magnetic Attitude Control System, Journal of Spacecraft
and Rockets 13 (1976) 282-287; the first term cancels the gyroscopic torque of non-principal axes.)
The dipole is constant in a step, and the body follows Euler's equations J dω/dt = m × b - ω × J ω.
Once the rate error is below the rate tolerance, the magnetorquers are off until the next maneuver.

Neglected: gravity gradient, drag and radiation pressure; the duty cycle of a magnetorquer within a
step (the dipole is the mean); errors of gyro and magnetometer in the law; the variation of the
field within a step, of which the mean is used.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

import numpy as np

from mgeo_attitude._typing import Bools, Floats, Ints


@dataclass(frozen=True)
class SlewLimits:
    """Limits on changes of the body rate, due to maximum acceleration and maximum wheel torque.

    Attributes
    ----------
    max_acceleration : float
        Maximum angular acceleration about each body axis [rad/s²]; may be infinite.
    max_torque : float
        Maximum torque of a wheel for ramps [N m]; may be infinite.
    inertia : array, shape (3, 3)
        Inertia of the satellite [kg m²].
    load_matrix : array, shape (k, 3)
        Allocation of a torque to the wheels; see `Wheels.compute_load_matrix`.
    initial_rate : array, shape (3,)
        Body rate before the first ramp [rad/s].
    """

    max_acceleration: float
    max_torque: float
    inertia: Floats
    load_matrix: Floats = field(default_factory=lambda: np.eye(3))
    initial_rate: Floats = field(default_factory=lambda: np.zeros(3))

    def compute_ramp_time(self, rate_change: Floats) -> Floats:
        """Return the shortest time [s] in which the body rate can change by given amounts.

        The rate changes along a straight line, with the torque J dω/dt; see equation (1)
        of docs/explanation/maneuvers-and-constraints.md.

        Parameters
        ----------
        rate_change : array, shape (..., 3)
            Changes of the body rate [rad/s].

        Returns
        -------
        array, shape (...)
        """
        acceleration = np.abs(rate_change).max(axis=-1) / self.max_acceleration
        torque = (
            np.abs(rate_change @ self.inertia @ self.load_matrix.T).max(axis=-1) / self.max_torque
        )
        ramp_time: Floats = np.maximum(acceleration, torque)
        return ramp_time


@dataclass(frozen=True)
class MagnetorquerDrive:
    """Simulator of the rotation of a satellite whose only actuators are magnetorquers.

    One simulator is used for all designs of a scenario.

    Attributes
    ----------
    inertia : array, shape (3, 3)
        Inertia of the satellite [kg m²].
    max_dipole : array, shape (3,)
        Maximum mean dipole of a step along each body axis [A m²].
    residual_dipole : array, shape (3,)
        Constant residual dipole, body axes [A m²].
    rate_tolerance : float
        Rate error at which the magnetorquers switch off [rad/s].
    time_constant : float
        Time constant T of the control law [s].
    field : array, shape (n_steps + 1, 3)
        Geomagnetic field [T], GCRS.
    initial_attitude : array, shape (3, 3)
        GCRS-to-body matrix at the start.
    initial_rate : array, shape (3,)
        Body rate at the start [rad/s].
    """

    inertia: Floats
    max_dipole: Floats
    residual_dipole: Floats
    rate_tolerance: float
    time_constant: float
    field: Floats
    initial_attitude: Floats
    initial_rate: Floats

    def rotate(self, rotation: Floats) -> MagnetorquerDrive:
        """Return a copy of the simulator with a rotated initial attitude.

        The field is rotated instead of the attitude; see `FilterModel.rotate_initial_attitude`.

        Parameters
        ----------
        rotation : array, shape (3, 3)
            Rotation of the initial attitude.
        """
        return dataclasses.replace(self, field=self.field @ rotation)

    def compute_rates(
        self, rates: Floats, starts: Ints, step: float, n_steps: int
    ) -> tuple[Floats, Floats, Bools]:
        """Compute the body rates that the magnetorquers achieve in each step for given maneuvers.

        Parameters
        ----------
        rates : array, shape (n, m, 3)
            Commanded rates of the maneuvers [rad/s].
        starts : array, shape (n, m)
            First step of each maneuver. A maneuver with the same start as the next one is skipped.
        step : float
            Filter step [s].
        n_steps : int
            Number of steps, limited to those with a known field.

        Returns
        -------
        mean, end : arrays, shape (n, k, 3)
            Constant rate equivalent to the rotation in each step, and rate at the end of the step
            [rad/s].
        free : array of bool, shape (n, k)
            Whether the magnetorquers are off.
        """
        # This import loads numba.
        from mgeo_attitude.maneuvers.rigid_body import compute_driven_rates

        shape = len(rates), min(n_steps, len(self.field) - 1)
        mean, end = np.zeros((*shape, 3)), np.zeros((*shape, 3))
        free = np.zeros(shape, dtype=np.bool_)
        body = self.inertia, np.linalg.inv(self.inertia), self.initial_attitude, self.initial_rate
        law = self.max_dipole, self.residual_dipole, self.rate_tolerance, self.time_constant
        plan = np.ascontiguousarray(rates), np.ascontiguousarray(starts)
        compute_driven_rates(body, law, self.field, plan, step, mean, end, free)
        return mean, end, free
