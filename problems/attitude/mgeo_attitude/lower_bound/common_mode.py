"""Lower bounds of body-fixed errors that resemble an inertial error, such as the attitude error.

A misalignment common to all sensors has the same effect as an attitude error. A bias common to all
magnetometers has the same effect as a field error. Only rotation of the body distinguishes the
errors, at rates that maneuvers allow. The inertial error can then compensate the body-fixed error
only as far as its process noise permits.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.lower_bound.curves import bounds_from_information


@dataclass(frozen=True)
class InertialErrorInformation:
    """Fisher information that one sensor provides about an inertial error, such as the attitude
    error.

    Attributes
    ----------
    inertial_error : str
        Name of the inertial error c, which is fixed in GCRS.
    trace : array, shape (n,)
        Trace of the information about c in each sample.
    body_fixed_errors : dict of str to BodyFixedError
        Body-fixed errors e of the sensor with the same effect on measurements as c = G Cᵀ e, where
        C is the attitude.
    """

    inertial_error: str
    trace: Floats
    body_fixed_errors: dict[str, BodyFixedError]


class BodyFixedError(NamedTuple):
    """Fisher information that a sensor provides about one of its body-fixed errors, such as its
    bias.

    An inertial error has the same effect on the measurements.

    Attributes
    ----------
    trace : array, shape (n,)
        Trace of the information in each sample.
    v : array, shape (n, 3), or None
        Vector with G = [v×] in GCRS, for a misalignment, which resembles an error of the vector v;
        None for G = I.
    """

    trace: Floats
    v: Floats | None

    def has_same_transformation(self, other: BodyFixedError) -> bool:
        """Return True if both errors have the same transformation matrix G to the inertial error.

        `InertialErrorInformation.body_fixed_errors` defines G.
        """
        if self.v is None or other.v is None:
            return self.v is other.v
        return bool((self.v == other.v).all())


class InertialErrorDynamics(NamedTuple):
    """Decay, process noise and initial information of an error expressed in inertial axes.

    Attributes
    ----------
    decay, noise : float
        Decay factor and smallest process-noise variance of a step.
    initial_information : array, shape (3, 3)
        Inverse of the initial covariance.
    """

    decay: float
    noise: float
    initial_information: Floats


def bound_dynamics_information(
    dynamics: InertialErrorDynamics, max_angle: float, v: Floats | None, n_samples: int
) -> Floats:
    """Return an upper bound on the information that distinguishes a body-fixed error from an
    inertial error.

    The inertial error can have the same effect on the measurements, but would then have to follow
    the rotation of the body. The smaller its process noise, the more information contradicts this
    motion. The bound includes the initial information about the inertial error, and is accumulated
    up to each sample.

    See equation (11) of docs/explanation/lower-bound.md.

    Parameters
    ----------
    dynamics : InertialErrorDynamics
    max_angle : float
        Largest rotation of the body in a step [rad].
    v : array, shape (n, 3), or None
        See `BodyFixedError`.
    n_samples : int
        Number of samples.

    Returns
    -------
    array, shape (n,)
        Upper bound on the trace of the information, up to each sample.
    """
    information, decay, min_trace = (
        np.zeros(n_samples),
        dynamics.decay,
        1.0 + 2.0 * np.cos(min(max_angle, np.pi)),
    )
    if (
        v is None
    ):  # |R - decay I|² for the rotation R of a step, whose trace is at least `min_trace`.
        information[0] = np.trace(dynamics.initial_information)
        information[1:] = 3.0 * (1.0 + decay**2) - 2.0 * decay * min_trace
    else:  # |[v'×] R - decay [v×]|², where tr [v'×]ᵀ[v×] R = (v' v) tr R - v' R v.
        norms, products = np.linalg.norm(v, axis=1), np.sum(v[1:] * v[:-1], axis=1)
        information[0] = 2.0 * norms[0] ** 2 * np.linalg.eigvalsh(dynamics.initial_information)[-1]
        min_product_trace = (
            np.minimum(min_trace * products, 3.0 * products) - norms[1:] * norms[:-1]
        )
        information[1:] = 2.0 * (
            norms[1:] ** 2 + (decay * norms[:-1]) ** 2 - decay * min_product_trace
        )
    information[1:] /= dynamics.noise
    return np.cumsum(information)


def bound_common_modes(
    name: str,
    dynamics: InertialErrorDynamics,
    observations: Sequence[InertialErrorInformation],
    initial_information: dict[str, Floats],
    max_angle: float,
) -> Iterator[tuple[str, Floats]]:
    """Yield lower bounds on the variances of an inertial error and of the body-fixed errors that
    resemble it.

    For example, the misalignments of sensors resemble the attitude error. Each bound is a lower
    bound on the sum of three variances. See equation (10) of docs/explanation/lower-bound.md.

    Parameters
    ----------
    name : str
        Name of the inertial error.
    dynamics : InertialErrorDynamics
    observations : sequence of InertialErrorInformation
        Information of all sensors about the inertial error.
    initial_information : dict of array, shape (3, 3)
        Initial information about each block. The blocks must not be correlated.
    max_angle : float
        Largest rotation of the body in a step [rad].

    Yields
    ------
    tuple of str and array, shape (n,)
        Name of the block, and bound on the sum of its variances. A block may occur several times.
    """
    if dynamics.noise <= 0.0:  # Without process noise, the inertial error cannot follow the body.
        return
    totals = [np.cumsum(observation.trace) for observation in observations]
    for observation in observations:
        for block, error in observation.body_fixed_errors.items():
            scale = 1.0 if error.v is None else np.sum(error.v**2, axis=1).max()
            opposing = bound_dynamics_information(dynamics, max_angle, error.v, len(error.trace))
            for other, total in zip(observations, totals, strict=True):
                if other is not observation:
                    compensating_errors = [
                        initial_information[similar_block]
                        for similar_block, similar in other.body_fixed_errors.items()
                        if similar.has_same_transformation(error)
                    ]
                    opposing = opposing + _reduce_by_compensation(
                        scale * total, compensating_errors
                    )
            gained = np.cumsum(error.trace)
            yield (
                block,
                bounds_from_information(
                    initial_information[block], gained * opposing / (gained + opposing)
                ).variance_sum,
            )
            if error.v is None:  # The inertial error can equal the rotated error completely.
                opposing = opposing + _reduce_by_compensation(gained, [initial_information[block]])
                yield name, bounds_from_information(np.zeros((3, 3)), opposing).variance_sum


def _reduce_by_compensation(information: Floats, error_information: Sequence[Floats]) -> Floats:
    """Reduce a sensor's information about an inertial error to account for a body-fixed error
    that could cause the same measurements.

    The result is the trace of the information. The initial information about the body-fixed error
    limits the reduction.
    """
    if not error_information:
        return information
    initial_trace = float(np.trace(error_information[0]))
    return information * initial_trace / (information + initial_trace)
