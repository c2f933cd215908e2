"""Initial attitude, attitude uncertainty and body rate of a run."""

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

#: Tolerance on unit vectors and right angles, for numbers that are typed with four digits.
_TOLERANCE = 1e-3

#: Function of a `Place` that returns vectors, shape (n, 3).
_Vectors = Callable[["Environment | SatelliteState"], Floats]


def _compute_momentum(orbit_state: Environment | SatelliteState) -> Floats:
    return np.cross(orbit_state.position, orbit_state.velocity)


def _compute_orbital_rate(orbit_state: Environment | SatelliteState) -> Floats:
    """Return the angular rate of the radius vector [rad/s], GCRS."""
    rate: Floats = _compute_momentum(orbit_state) / (orbit_state.position**2).sum(
        axis=1, keepdims=True
    )
    return rate


def _compute_velocity_rate(orbit_state: Environment | SatelliteState) -> Floats:
    """Return the angular rate of the velocity under the acceleration -μ r / r³ [rad/s], GCRS."""
    cube = np.linalg.norm(orbit_state.position, axis=1, keepdims=True) ** 3
    square = (orbit_state.velocity**2).sum(axis=1, keepdims=True)
    rate: Floats = EARTH_MU * _compute_momentum(orbit_state) / (cube * square)
    return rate


#: Target direction, reference direction of the clock angle, and angular rate of each pointing law.
_LAWS: dict[str, tuple[_Vectors, _Vectors, _Vectors]] = {
    "nadir": (lambda at: -at.position, lambda at: at.velocity, _compute_orbital_rate),
    "velocity": (lambda at: at.velocity, lambda at: -at.position, _compute_velocity_rate),
    "sun": (lambda at: at.sun, _compute_momentum, lambda at: np.zeros_like(at.sun)),
}

POINTING_LAWS = ("inertial", *_LAWS)


@dataclass(frozen=True, kw_only=True)
class InitialConditions(Settings):
    """Initial attitude with its uncertainty, and initial body rate.

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
    """attitude error, 1-sigma per axis"""
    pointing: Annotated[str, restrict_to(POINTING_LAWS)] = "inertial"
    """attitude law: fixed in GCRS (quaternion or axes; default: along GCRS), or target of the
    axis"""
    quaternion: tuple[float, float, float, float] | None = None
    """attitude from GCRF to body, scalar last, as in plans; for 'inertial'"""
    axes: tuple[Vector, ...] | None = None
    """body x, y and z as unit vectors in GCRS; alternative to the quaternion"""
    axis: Vector | None = None
    """pointing body axis, a unit vector; default: z"""
    clock_deg: Degrees | None = Field(default=None, ge=-360.0, le=360.0)
    """rotation about the pointing axis; at zero, body z (x if the axis is within 45 deg of z) is
    closest to the velocity (nadir), nadir (velocity) or the orbit normal (sun)"""
    rate_deg_s: Annotated[Vector | None, Unit("deg/s")] = None
    """body rate; default: the rate of the attitude law, orbital or zero"""

    def __post_init__(self) -> None:
        fixed = self.pointing == "inertial"
        foreign = ("axis", "clock_deg") if fixed else ("quaternion", "axes")
        for key in foreign:
            value = getattr(self, key)
            expect(value is None, key, value, f"no value with pointing = {self.pointing!r}")
        if self.axes is not None:
            expect(self.quaternion is None, "axes", self.axes, "no value with a quaternion")
            expect(_are_axes(self.axes), "axes", self.axes, "three right-handed unit vectors")
        for key in ("quaternion", "axis"):
            if (value := getattr(self, key)) is not None:
                length = math.hypot(*value)
                sound = abs(length - 1.0) <= _TOLERANCE
                expect(sound, key, value, f"a length of 1, not {length:.6g}")

    def compute_attitude(self, orbit_state: Environment | SatelliteState) -> Floats:
        """Return the attitude of the law, GCRS to body, shape (n, 3, 3).

        Raises
        ------
        InvalidValue
            If the target is parallel to the reference direction of the clock angle.
        """
        if self.pointing == "inertial":
            return np.repeat(
                self._build_inertial_attitude()[None], len(orbit_state.position), axis=0
            )
        target, toward, _ = _LAWS[self.pointing]
        axis = np.array(self.axis or (0.0, 0.0, 1.0))
        clock = math.radians(self.clock_deg or 0.0)
        try:
            return compute_pointing_attitudes(
                axis / np.linalg.norm(axis), target(orbit_state), toward(orbit_state), clock
            )
        except ValueError as error:
            expected = f"expected another pointing: {error}"
            raise InvalidValue("initial.pointing", self.pointing, expected) from None

    def compute_law_rate(self, orbit_state: Environment | SatelliteState) -> Floats:
        """Return the body rate of the attitude law [rad/s], shape (n, 3).

        The rate is that of a Keplerian orbit. It is zero for inertial and Sun pointing; the drift
        of the orbital plane and the Sun's motion of one degree per day are neglected.
        """
        if self.pointing == "inertial":
            return np.zeros((len(orbit_state.position), 3))
        return self._compute_law_rate(self.compute_attitude(orbit_state), orbit_state)

    def _compute_law_rate(self, attitude: Floats, at: Environment | SatelliteState) -> Floats:
        rates: Floats = np.einsum("kij,kj->ki", attitude, _LAWS[self.pointing][2](at))
        return rates

    def evaluate_law(self, orbit_source: OrbitSource, time: float) -> tuple[Floats, Floats]:
        """Return attitude, GCRS to body, and body rate [rad/s] of the law, shapes (3, 3) and (3,).

        Parameters
        ----------
        orbit_source : Course
        time : float
            Time after the epoch [s], possibly after the end of the scenario's run.
        """
        if self.pointing == "inertial":  # independent of the position
            return self._build_inertial_attitude(), np.zeros(3)
        at = SatelliteState.from_times(orbit_source, np.array([time]))
        attitude = self.compute_attitude(at)
        return attitude[0], self._compute_law_rate(attitude, at)[0]

    def compute_rate(self, orbit_state: Environment | SatelliteState) -> Floats:
        """Return the body rate at the first instant [rad/s], shape (3,)."""
        given = self.rate_deg_s
        return self.compute_law_rate(orbit_state)[0] if given is None else np.radians(given)

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
