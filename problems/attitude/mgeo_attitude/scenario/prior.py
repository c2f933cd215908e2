"""What a run starts from when the satellite has been calibrated before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import expect
from mgeo_attitude.settings.types import Unit, Vector

#: Quaternions and matrices are written with all their digits.
_ROUNDING = 1e-9


@dataclass(frozen=True, kw_only=True)
class Prior(Settings):
    """Estimates at the epoch, and the covariance of their errors, as a calibration leaves them.

    They take the place of attitude and rate in ``[initial]`` and of all initial 1-sigmas. Numbers
    are in the filter's units (rad, rad/s, 1; a field in units of 50 µT); estimates of rotations are
    vectors of `rotation.rotate`, their errors those of the rotations that remain, R = R̂ R(e).

    Examples
    --------
    >>> import numpy as np
    >>> from mgeo_attitude.scenario import Prior
    >>> prior = Prior(
    ...     quaternion=(0.0, 0.0, 0.0, 1.0),
    ...     rate_deg_s=(0.0, 0.06, 0.0),
    ...     states=((0.0, 0.0, 0.0),) * 5,
    ...     covariance=(1e-6 * np.eye(18)).tolist(),
    ... )
    >>> len(prior.states)
    5
    """

    quaternion: tuple[float, float, float, float]
    """attitude from GCRF to body at the epoch, scalar last"""
    rate_deg_s: Annotated[Vector, Unit("deg/s")]
    """body rate at the epoch"""
    states: tuple[Vector, ...]
    """estimates of gyro and sensors, a row for each block after the attitude, filter's units"""
    covariance: tuple[tuple[float, ...], ...]
    """of the errors of attitude and these estimates, rows first, filter's units squared"""

    def __post_init__(self) -> None:
        check_quaternion(self.quaternion)
        check_covariance(self.covariance, 3 * (1 + len(self.states)))

    @property
    def attitude(self) -> Floats:
        """GCRS to body, shape (3, 3)."""
        from scipy.spatial.transform import Rotation

        C: Floats = Rotation.from_quat(self.quaternion).as_matrix().T
        return C

    @property
    def rate(self) -> Floats:
        """Body rate [rad/s], shape (3,)."""
        return np.radians(self.rate_deg_s)

    @property
    def estimates(self) -> Floats:
        """Of all states, shape (n_states,); zero for the attitude."""
        return np.concatenate([np.zeros(3), *map(np.array, self.states)])

    @property
    def sigma(self) -> Floats:
        """1-sigma of every state, shape (n_states,)."""
        return np.sqrt(np.diag(np.array(self.covariance)))

    @property
    def correlation(self) -> Floats:
        """Of the errors, shape (n_states, n_states)."""
        correlation: Floats = np.array(self.covariance) / np.outer(self.sigma, self.sigma)
        np.fill_diagonal(correlation, 1.0)
        return 0.5 * (correlation + correlation.T)


def prior_of(document: Mapping[str, Any], suite: Suite) -> Prior:
    """Attitude, rate, estimates and covariance of a calibration's document.

    Raises
    ------
    InvalidValue
        For states of another satellite, or what is no attitude, rate, estimate or covariance.
    """
    rows = tuple(states_of(document, suite).values())
    given = {key: document[key] for key in ("quaternion", "rate_deg_s", "covariance")}
    return Prior(**given, states=rows)


def states_of(document: Mapping[str, Any], suite: Suite) -> Mapping[str, Any]:
    """The states of a document by their blocks, which are a satellite's but for the attitude.

    Raises
    ------
    InvalidValue
        For those of another satellite.
    """
    states: Mapping[str, Any] = document["states"]
    blocks = list(suite.blocks[1:])
    expect(list(states) == blocks, "states", list(states), ", ".join(blocks))
    return states


def check_quaternion(quaternion: Sequence[float]) -> None:
    """Refuse what is not four numbers of unit length.

    Raises
    ------
    InvalidValue
    """
    length = float(np.linalg.norm(quaternion))
    sound = len(quaternion) == 4 and abs(length - 1.0) <= _ROUNDING
    unit = f"four numbers of unit length, not {length:.12g}"
    expect(sound, "quaternion", quaternion, unit)


def check_covariance(matrix: Sequence[Sequence[float]] | ArrayLike, n: int) -> None:
    """Refuse what is no covariance of n states.

    Raises
    ------
    InvalidValue
    """
    rows = [len(row) for row in matrix]  # type: ignore[union-attr, arg-type]
    square = len(rows) == n and set(rows) == {n}
    shape = f"{len(rows)} rows of {', '.join(map(str, sorted(set(rows)))) or 0}"
    expect(square, "covariance", shape, f"{n} x {n} numbers, three a block and axis")
    found = np.array(matrix, dtype=float)
    scale = np.sqrt(np.abs(np.diag(found)))
    with np.errstate(divide="ignore", invalid="ignore"):
        correlation = found / scale / scale[:, None]
    regular = np.isfinite(correlation).all() and np.allclose(correlation, correlation.T, 0, 1e-9)
    if not regular or np.linalg.eigvalsh(correlation)[0] <= 0.0:
        worst = f"least variance {np.diag(found).min():.6g}"
        expect(False, "covariance", worst, "a symmetric positive definite matrix")
