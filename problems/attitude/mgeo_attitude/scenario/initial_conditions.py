"""Initial attitude, attitude uncertainty and body rate of a plan."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import EARTH_MU
from mgeo_attitude.environment.directions import SatelliteState, compute_pointing_attitudes
from mgeo_attitude.environment.environment import Environment, OrbitSource
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, expect
from mgeo_attitude.settings.types import Degrees, Unit, Vector, restrict_to

#: Tolerance on unit vectors and right angles, for numbers with four digits.
_TOLERANCE = 1e-3

#: Function that returns one vector for each orbit state, shape (n, 3).
_Vectors = Callable[["Environment | SatelliteState"], Floats]


def _compute_momentum(orbit_state: Environment | SatelliteState) -> Floats:
    return np.cross(orbit_state.position, orbit_state.velocity)


def _compute_orbital_rate(orbit_state: Environment | SatelliteState) -> Floats:
    """Return the angular velocity of the radius vector in GCRS axes [rad/s], shape (n, 3)."""
    rate: Floats = _compute_momentum(orbit_state) / (orbit_state.position**2).sum(
        axis=1, keepdims=True
    )
    return rate


def _compute_velocity_rate(orbit_state: Environment | SatelliteState) -> Floats:
    """Return the angular velocity of the velocity vector in a Keplerian orbit [rad/s].

    The result is in GCRS axes and has shape (n, 3).
    """
    cube = np.linalg.norm(orbit_state.position, axis=1, keepdims=True) ** 3
    square = (orbit_state.velocity**2).sum(axis=1, keepdims=True)
    rate: Floats = EARTH_MU * _compute_momentum(orbit_state) / (cube * square)
    return rate


#: Target direction, reference direction of the clock angle, and angular rate of each pointing law.
_LAWS: dict[str, tuple[_Vectors, _Vectors, _Vectors]] = {
    "nadir": (lambda state: -state.position, lambda state: state.velocity, _compute_orbital_rate),
    "velocity": (
        lambda state: state.velocity,
        lambda state: -state.position,
        _compute_velocity_rate,
    ),
    "sun": (lambda state: state.sun, _compute_momentum, lambda state: np.zeros_like(state.sun)),
}

POINTING_LAWS = ("inertial", *_LAWS)


@dataclass(frozen=True, kw_only=True)
class InitialConditions(Settings):
    """Initial attitude and body rate, with the uncertainty of the attitude.

    The attitude follows from an attitude law at the epoch: fixed in inertial space, or with a body
    axis toward the Earth's center, along the velocity or toward the Sun. Uncertainties of gyro and
    sensor errors belong to the gyro and the sensors.

    Examples
    --------
    >>> from mgeo_attitude.scenario import InitialConditions
    >>> InitialConditions(pointing="nadir", attitude_deg=2.0).pointing
    'nadir'
    """

    attitude_deg: Degrees = Field(default=5.0, gt=0.0, le=180.0)
    """initial attitude error, 1-sigma per axis"""
    pointing: Annotated[str, restrict_to(POINTING_LAWS)] = "inertial"
    """attitude law: 'inertial' for an attitude that is fixed in GCRS, given by quaternion or axes
    (default: body axes along GCRS); otherwise the target of the pointing axis: 'nadir', 'velocity'
    or 'sun'"""
    quaternion: tuple[float, float, float, float] | None = None
    """attitude from GCRF to body, scalar last, as in plans; only with pointing = 'inertial'"""
    axes: tuple[Vector, ...] | None = None
    """body x, y and z as unit vectors in GCRS; an alternative to the quaternion"""
    axis: Vector | None = None
    """pointing axis, a unit vector in body axes; default: z"""
    clock_deg: Degrees | None = Field(default=None, ge=-360.0, le=360.0)
    """rotation about the pointing axis. At zero, body z (body x if the pointing axis is within 45
    deg of z) is closest to the velocity ('nadir'), to nadir ('velocity') or to the orbit normal
    ('sun')"""
    rate_deg_s: Annotated[Vector | None, Unit("deg/s")] = None
    """initial body rate; default: the rate of the attitude law, orbital or zero"""

    def __post_init__(self) -> None:
        is_inertial = self.pointing == "inertial"
        for key in ("axis", "clock_deg") if is_inertial else ("quaternion", "axes"):
            value = getattr(self, key)
            expect(value is None, key, value, f"no value with pointing = {self.pointing!r}")
        if self.axes is not None:
            expect(self.quaternion is None, "axes", self.axes, "no value with a quaternion")
            expect(_are_axes(self.axes), "axes", self.axes, "three right-handed unit vectors")
        for key in ("quaternion", "axis"):
            if (value := getattr(self, key)) is not None:
                length = math.hypot(*value)
                is_unit = abs(length - 1.0) <= _TOLERANCE
                expect(is_unit, key, value, f"a length of 1, not {length:.6g}")

    def compute_attitude(self, orbit_state: Environment | SatelliteState) -> Floats:
        """Return the attitude that the attitude law, such as nadir pointing, prescribes at each
        orbit state.

        Parameters
        ----------
        orbit_state : Environment or SatelliteState
            Position, velocity and Sun direction at n instants.

        Returns
        -------
        array, shape (n, 3, 3)
            Matrices from GCRS to body.

        Raises
        ------
        InvalidValue
            If the target is parallel to the reference direction of the clock angle.
        """
        if self.pointing == "inertial":
            return np.repeat(
                self._build_inertial_attitude()[None], len(orbit_state.position), axis=0
            )
        target, reference, _ = _LAWS[self.pointing]
        axis = np.array(self.axis or (0.0, 0.0, 1.0))
        clock = math.radians(self.clock_deg or 0.0)
        try:
            return compute_pointing_attitudes(
                axis / np.linalg.norm(axis), target(orbit_state), reference(orbit_state), clock
            )
        except ValueError as error:
            expected = f"expected another attitude law: {error}"
            raise InvalidValue("initial.pointing", self.pointing, expected) from None

    def compute_law_rate(self, orbit_state: Environment | SatelliteState) -> Floats:
        """Return the body rate [rad/s] that the attitude law, such as nadir pointing, prescribes at
        each orbit state.

        The rate is that of a Keplerian orbit. It is zero for inertial and Sun pointing; the drift
        of the orbital plane and the Sun's motion of one degree per day are neglected.

        Parameters
        ----------
        orbit_state : Environment or SatelliteState
            Position, velocity and Sun direction at n instants.

        Returns
        -------
        array, shape (n, 3)
        """
        if self.pointing == "inertial":
            return np.zeros((len(orbit_state.position), 3))
        return self._compute_law_rate(self.compute_attitude(orbit_state), orbit_state)

    def _compute_law_rate(
        self, attitude: Floats, orbit_state: Environment | SatelliteState
    ) -> Floats:
        rates: Floats = np.einsum("kij,kj->ki", attitude, _LAWS[self.pointing][2](orbit_state))
        return rates

    def evaluate_law(self, orbit_source: OrbitSource, time: float) -> tuple[Floats, Floats]:
        """Return the attitude and the body rate that the attitude law prescribes at a given time.

        Parameters
        ----------
        orbit_source : OrbitSource
            Scenario, or another object with an orbit and an epoch.
        time : float
            Time after the epoch [s], possibly after the end of the scenario.

        Returns
        -------
        attitude : array, shape (3, 3)
            Matrix from GCRS to body.
        rate : array, shape (3,)
            Body rate [rad/s].
        """
        if self.pointing == "inertial":  # This law is independent of the position.
            return self._build_inertial_attitude(), np.zeros(3)
        orbit_state = SatelliteState.from_times(orbit_source, np.array([time]))
        attitude = self.compute_attitude(orbit_state)
        return attitude[0], self._compute_law_rate(attitude, orbit_state)[0]

    def compute_rate(self, orbit_state: Environment | SatelliteState) -> Floats:
        """Return the initial body rate [rad/s], shape (3,).

        If no rate is specified, the attitude law determines the rate at the first orbit state.
        """
        rate = self.rate_deg_s
        return self.compute_law_rate(orbit_state)[0] if rate is None else np.radians(rate)

    def _build_inertial_attitude(self) -> Floats:
        from scipy.spatial.transform import Rotation

        C: Floats = np.eye(3)
        if self.quaternion is not None:
            C = Rotation.from_quat(self.quaternion).as_matrix().T
        if self.axes is not None:
            C = Rotation.from_matrix(self.axes).as_matrix()
        return C


def _are_axes(axes: tuple[tuple[float, float, float], ...]) -> bool:
    C = np.array(axes)
    if C.shape != (3, 3):
        return False
    return bool(np.abs(C @ C.T - np.eye(3)).max() <= _TOLERANCE and np.linalg.det(C) > 0.0)
