"""Prior of a plan: the result of a previous calibration."""

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

#: Tolerance on numbers that are saved with all their digits.
_ROUNDING = 1e-9


@dataclass(frozen=True, kw_only=True)
class Prior(Settings):
    """Result of a calibration from which a scenario starts.

    The prior contains estimates of the attitude, the body rate and the error states at the epoch,
    and their covariance. The prior replaces attitude and rate of ``[initial]`` and all initial
    1-sigmas. Numbers are in the filter's units (rad, rad/s, 1; a field in units of 50 µT).
    Estimates of rotations are rotation vectors of `rotation.rotate`; their errors are the residual
    rotations e in R = R̂ R(e).

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
    """estimated error states, one row per block after the attitude, in the filter's units"""
    covariance: tuple[tuple[float, ...], ...]
    """covariance of the errors of attitude and estimated error states, row by row, in the filter's
    units squared"""

    def __post_init__(self) -> None:
        check_quaternion(self.quaternion)
        check_covariance(self.covariance, 3 * (1 + len(self.states)))

    @property
    def attitude(self) -> Floats:
        """Attitude matrix from GCRS to body at the epoch, shape (3, 3)."""
        from scipy.spatial.transform import Rotation

        C: Floats = Rotation.from_quat(self.quaternion).as_matrix().T
        return C

    @property
    def rate(self) -> Floats:
        """Body rate at the epoch [rad/s], shape (3,)."""
        return np.radians(self.rate_deg_s)

    @property
    def estimates(self) -> Floats:
        """Estimated error state with zeros for the attitude error, shape (n_states,)."""
        return np.concatenate([np.zeros(3), *map(np.array, self.states)])

    @property
    def sigma(self) -> Floats:
        """Estimation uncertainty (1-sigma) of each error-state component, shape (n_states,)."""
        return np.sqrt(np.diag(np.array(self.covariance)))

    @property
    def correlation(self) -> Floats:
        """Correlation matrix of the estimation errors, shape (n_states, n_states)."""
        correlation: Floats = np.array(self.covariance) / np.outer(self.sigma, self.sigma)
        np.fill_diagonal(correlation, 1.0)
        return 0.5 * (correlation + correlation.T)


def read_prior(calibration: Mapping[str, Any], suite: Suite) -> Prior:
    """Return the prior of a scenario from the saved result of a calibration.

    Parameters
    ----------
    calibration : mapping
        Calibration with the entries ``quaternion``, ``rate_deg_s``, ``states`` and ``covariance``.
    suite : Suite
        Suite whose error state the calibration must have.

    Raises
    ------
    InvalidValue
        If the error state is that of another suite, or if an entry is invalid.
    """
    rows = tuple(read_states(calibration, suite).values())
    entries = {key: calibration[key] for key in ("quaternion", "rate_deg_s", "covariance")}
    return Prior(**entries, states=rows)


def read_states(calibration: Mapping[str, Any], suite: Suite) -> Mapping[str, Any]:
    """Return a mapping from block names to the error states that a calibration estimated.

    The values are 3-vectors. The attitude is not included.

    Raises
    ------
    InvalidValue
        If the blocks are not those of the suite.
    """
    states: Mapping[str, Any] = calibration["states"]
    blocks = list(suite.blocks[1:])
    expect(list(states) == blocks, "states", list(states), ", ".join(blocks))
    return states


def check_quaternion(quaternion: Sequence[float]) -> None:
    """Raise InvalidValue unless a quaternion has four components and unit length."""
    length = float(np.linalg.norm(quaternion))
    is_valid = len(quaternion) == 4 and abs(length - 1.0) <= _ROUNDING
    expected = f"four numbers of unit length, not of length {length:.12g}"
    expect(is_valid, "quaternion", quaternion, expected)


def check_covariance(matrix: Sequence[Sequence[float]] | ArrayLike, n: int) -> None:
    """Raise InvalidValue unless a matrix is a valid covariance of n states.

    The matrix must have n rows and n columns, and be symmetric and positive definite.
    """
    rows = [len(row) for row in matrix]  # type: ignore[union-attr, arg-type]
    is_square = len(rows) == n and set(rows) == {n}
    shape = f"{len(rows)} rows of {', '.join(map(str, sorted(set(rows)))) or 0}"
    expect(is_square, "covariance", shape, f"{n} x {n} numbers, three rows per block")
    covariance = np.array(matrix, dtype=float)
    scale = np.sqrt(np.abs(np.diag(covariance)))
    with np.errstate(divide="ignore", invalid="ignore"):
        correlation = covariance / scale / scale[:, None]
    is_regular = np.isfinite(correlation).all() and np.allclose(correlation, correlation.T, 0, 1e-9)
    if not is_regular or np.linalg.eigvalsh(correlation)[0] <= 0.0:
        smallest = f"matrix with the smallest variance {np.diag(covariance).min():.6g}"
        expect(False, "covariance", smallest, "a symmetric positive definite matrix")
