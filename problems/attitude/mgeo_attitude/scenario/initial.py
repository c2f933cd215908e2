"""How a run begins: the attitude and how well it is known, and the body rate."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import EARTH_MU
from mgeo_attitude.environment.directions import Place, pointed
from mgeo_attitude.environment.environment import Course, Environment
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, expect
from mgeo_attitude.settings.types import Degrees, Unit, Vector, one_of

#: Unit vectors and right angles may be off by this: numbers are typed with four digits.
_TOLERANCE = 1e-3

#: A position or velocity, a direction: one vector of a `Place`, and what follows from it.
_Vectors = Callable[["Environment | Place"], Floats]


def _momentum(at: Environment | Place) -> Floats:
    return np.cross(at.position, at.velocity)


def _orbital_rate(at: Environment | Place) -> Floats:
    """Of the radius vector [rad/s], GCRS."""
    rate: Floats = _momentum(at) / (at.position**2).sum(axis=1, keepdims=True)
    return rate


def _rate_of_velocity(at: Environment | Place) -> Floats:
    """Of the velocity under the central acceleration -μ r / r³ [rad/s], GCRS."""
    cube = np.linalg.norm(at.position, axis=1, keepdims=True) ** 3
    square = (at.velocity**2).sum(axis=1, keepdims=True)
    rate: Floats = EARTH_MU * _momentum(at) / (cube * square)
    return rate


#: What is pointed at, what the clock angle is counted from, and the rate of both.
_LAWS: dict[str, tuple[_Vectors, _Vectors, _Vectors]] = {
    "nadir": (lambda at: -at.position, lambda at: at.velocity, _orbital_rate),
    "velocity": (lambda at: at.velocity, lambda at: -at.position, _rate_of_velocity),
    "sun": (lambda at: at.sun, _momentum, lambda at: np.zeros_like(at.sun)),
}

POINTINGS = ("inertial", *_LAWS)


@dataclass(frozen=True, kw_only=True)
class InitialConditions(Settings):
    """The attitude at the start, how well it is known, and the rate the satellite turns at.

    The attitude is that of a *law*, at the epoch: fixed in inertial space, or a body axis that
    points at the Earth's center, along the velocity or at the Sun. Gyro and sensors carry the
    uncertainty of their own errors.

    Examples
    --------
    >>> from mgeo_attitude.scenario import InitialConditions
    >>> InitialConditions(pointing="nadir", attitude_deg=2.0).pointing
    'nadir'
    """

    attitude_deg: Degrees = Field(default=5.0, gt=0.0, le=180.0)
    """attitude error, 1-sigma per axis"""
    pointing: Annotated[str, one_of(POINTINGS)] = "inertial"
    """attitude at the start: fixed (quaternion or axes; along GCRS), or axis at the target"""
    quaternion: tuple[float, float, float, float] | None = None
    """attitude from GCRF to body, scalar last, as plans have it; with 'inertial'"""
    axes: tuple[Vector, ...] | None = None
    """body x, y and z as unit vectors in GCRS, instead of the quaternion"""
    axis: Vector | None = None
    """body axis that points, a unit vector; z if none is given"""
    clock_deg: Degrees | None = Field(default=None, ge=-360.0, le=360.0)
    """turn about that axis, from where body z (x if the axis is within 45 deg of z) is nearest to
    the velocity (nadir), nadir (velocity), the orbit's normal (sun)"""
    rate_deg_s: Annotated[Vector | None, Unit("deg/s")] = None
    """body rate; if none is given that of the pointing, orbital or none"""

    def __post_init__(self) -> None:
        fixed = self.pointing == "inertial"
        foreign = ("axis", "clock_deg") if fixed else ("quaternion", "axes")
        for key in foreign:
            value = getattr(self, key)
            expect(value is None, key, value, f"nothing with pointing = {self.pointing!r}")
        if self.axes is not None:
            expect(self.quaternion is None, "axes", self.axes, "nothing beside a quaternion")
            expect(_are_axes(self.axes), "axes", self.axes, "three right-handed unit vectors")
        for key in ("quaternion", "axis"):
            if (value := getattr(self, key)) is not None:
                length = math.hypot(*value)
                sound = abs(length - 1.0) <= _TOLERANCE
                expect(sound, key, value, f"a length of 1, not {length:.6g}")

    def attitude(self, at: Environment | Place) -> Floats:
        """The law, GCRS to body, shape (n, 3, 3).

        Raises
        ------
        InvalidValue
            If what is pointed at leaves the clock angle open.
        """
        if self.pointing == "inertial":
            return np.repeat(self._fixed()[None], len(at.position), axis=0)
        target, toward, _ = _LAWS[self.pointing]
        axis = np.array(self.axis or (0.0, 0.0, 1.0))
        clock = math.radians(self.clock_deg or 0.0)
        try:
            return pointed(axis / np.linalg.norm(axis), target(at), toward(at), clock)
        except ValueError as error:
            expected = f"expected another pointing: {error}"
            raise InvalidValue("initial.pointing", self.pointing, expected) from None

    def law_rate(self, at: Environment | Place) -> Floats:
        """Body rate of the law [rad/s], shape (n, 3); zero if it is inertial or at the Sun.

        Of a Keplerian orbit; what turns its plane, and the Sun's degree a day, is left out.
        """
        if self.pointing == "inertial":
            return np.zeros((len(at.position), 3))
        return self._turning(self.attitude(at), at)

    def _turning(self, attitude: Floats, at: Environment | Place) -> Floats:
        rates: Floats = np.einsum("kij,kj->ki", attitude, _LAWS[self.pointing][2](at))
        return rates

    def law(self, course: Course, time: float) -> tuple[Floats, Floats]:
        """Attitude, GCRS to body, and body rate of the law at a time [s], shapes (3, 3) and (3,).

        It may be later than the scenario's run ends.
        """
        if self.pointing == "inertial":  # wherever the satellite is
            return self._fixed(), np.zeros(3)
        at = Place.at(course, np.array([time]))
        attitude = self.attitude(at)
        return attitude[0], self._turning(attitude, at)[0]

    def rate(self, at: Environment | Place) -> Floats:
        """Body rate at the first instant [rad/s], shape (3,)."""
        given = self.rate_deg_s
        return self.law_rate(at)[0] if given is None else np.radians(given)

    def _fixed(self) -> Floats:
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
