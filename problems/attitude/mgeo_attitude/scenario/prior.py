"""Prior of a run: the result of a previous calibration."""

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

#: Tolerance on numbers that are written with all their digits.
_ROUNDING = 1e-9


@dataclass(frozen=True, kw_only=True)
class Prior(Settings):
    """Estimates at the epoch and the covariance of their errors, as a calibration yields them.

    The prior replaces attitude and rate of ``[initial]`` and all initial 1-sigmas. Numbers are in
    the filter's units (rad, rad/s, 1; a field in units of 50 µT). Estimates of rotations are
    rotation vectors of `rotation.rotate`; their errors are the residual rotations e in R = R̂ R(e).

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
    """estimated states, one row per block after the attitude, in the filter's units"""
    covariance: tuple[tuple[float, ...], ...]
    """covariance of the errors of attitude and estimated states, by rows, in the filter's units
    squared"""

    def __post_init__(self) -> None:
        check_quaternion(self.quaternion)
        check_covariance(self.covariance, 3 * (1 + len(self.states)))

    @property
    def attitude(self) -> Floats:
        """Attitude from GCRS to body, shape (3, 3)."""
        from scipy.spatial.transform import Rotation

        C: Floats = Rotation.from_quat(self.quaternion).as_matrix().T
        return C

    @property
    def rate(self) -> Floats:
        """Body rate [rad/s], shape (3,)."""
        return np.radians(self.rate_deg_s)

    @property
    def estimates(self) -> Floats:
        """Estimates of all states, shape (n_states,); zero for the attitude error."""
        return np.concatenate([np.zeros(3), *map(np.array, self.states)])

    @property
    def sigma(self) -> Floats:
        """1-sigma of every state, shape (n_states,)."""
        return np.sqrt(np.diag(np.array(self.covariance)))

    @property
    def correlation(self) -> Floats:
        """Correlation of the errors, shape (n_states, n_states)."""
        correlation: Floats = np.array(self.covariance) / np.outer(self.sigma, self.sigma)
        np.fill_diagonal(correlation, 1.0)
        return 0.5 * (correlation + correlation.T)


def read_prior(document: Mapping[str, Any], suite: Suite) -> Prior:
    """Return the prior from the document of a calibration.

    Raises
    ------
    InvalidValue
        If the states are those of another satellite, or if an entry is invalid.
    """
    rows = tuple(read_states(document, suite).values())
    entries = {key: document[key] for key in ("quaternion", "rate_deg_s", "covariance")}
    return Prior(**entries, states=rows)


def read_states(document: Mapping[str, Any], suite: Suite) -> Mapping[str, Any]:
    """Return the states of a calibration document by block, without the attitude.

    Raises
    ------
    InvalidValue
        If the blocks are not those of the suite.
    """
    states: Mapping[str, Any] = document["states"]
    blocks = list(suite.blocks[1:])
    expect(list(states) == blocks, "states", list(states), ", ".join(blocks))
    return states


def check_quaternion(quaternion: Sequence[float]) -> None:
    """Check that a quaternion has four components and unit length.

    Raises
    ------
    InvalidValue
        If the quaternion is invalid.
    """
    length = float(np.linalg.norm(quaternion))
    sound = len(quaternion) == 4 and abs(length - 1.0) <= _ROUNDING
    unit = f"four numbers of unit length, not {length:.12g}"
    expect(sound, "quaternion", quaternion, unit)


def check_covariance(matrix: Sequence[Sequence[float]] | ArrayLike, n: int) -> None:
    """Check that a matrix is a covariance of n states.

    Raises
    ------
    InvalidValue
        If the shape is wrong or the matrix is not symmetric and positive definite.
    """
    rows = [len(row) for row in matrix]  # type: ignore[union-attr, arg-type]
    square = len(rows) == n and set(rows) == {n}
    shape = f"{len(rows)} rows of {', '.join(map(str, sorted(set(rows)))) or 0}"
    expect(square, "covariance", shape, f"{n} x {n} numbers, three rows per block")
    covariance = np.array(matrix, dtype=float)
    scale = np.sqrt(np.abs(np.diag(covariance)))
    with np.errstate(divide="ignore", invalid="ignore"):
        correlation = covariance / scale / scale[:, None]
    regular = np.isfinite(correlation).all() and np.allclose(correlation, correlation.T, 0, 1e-9)
    if not regular or np.linalg.eigvalsh(correlation)[0] <= 0.0:
        worst = f"least variance {np.diag(covariance).min():.6g}"
        expect(False, "covariance", worst, "a symmetric positive definite matrix")
