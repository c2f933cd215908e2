"""Trajectories of a batch, the partition of their states, and the spans of their samples."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.geometry.rotation import rotation_matrix, rotation_vector
from mgeo_attitude.sensors.suite import Suite

#: Number of samples per span. Equations are formed span by span to bound the memory.
SPAN_LENGTH = 2000


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Estimated attitude, gyro states and sensor states at each of N samples.

    Attributes
    ----------
    attitude : array, shape (N, 3, 3)
        Rotation matrices from body to GCRS.
    states : array, shape (N, n_states)
        States of the gyro and the sensors. A rotation is represented by twice its Gibbs vector, see
        `mgeo_attitude.geometry.rotation`. The attitude block is zero. Constant states follow from
        their value at the first sample.
    """

    attitude: Floats
    states: Floats

    def select_samples(self, low: int, high: int) -> Trajectory:
        return Trajectory(self.attitude[low:high], self.states[low:high])


@dataclass(frozen=True, eq=False)
class Partition:
    """Division of the states into stochastic states, which have process noise, and constant states.

    Attributes
    ----------
    stochastic : array of int, shape (d,)
        Stochastic states, driven by process noise and estimated at every sample: attitude, gyro
        bias with random walk, and sensor processes.
    constant : array of int, shape (c,)
        States without process noise, estimated at the first sample only.
    """

    stochastic: Ints
    constant: Ints

    @classmethod
    def from_suite(cls, suite: Suite) -> Partition:
        """Divide the states of a suite: states with a positive process noise density are
        stochastic, all others are constant.
        """
        driven = np.flatnonzero(suite.compute_noise_density() > 0.0)
        return cls(driven, np.setdiff1d(np.arange(suite.n_states), driven))


def split_into_spans(n_samples: int) -> Iterator[tuple[int, int, int]]:
    """Divide samples into consecutive spans that share one sample, and yield the bounds of each
    span.

    A span contains the samples low to high - 1, at most `SPAN_LENGTH` + 1. It starts with the last
    sample of the previous span, so that the step between the spans is included. `first` is the
    position in the span of the first sample that does not belong to the previous span: 0 for the
    first span, otherwise 1.

    Parameters
    ----------
    n_samples : int
        Number of samples to divide.

    Yields
    ------
    low, high : int
        Index of the first sample of the span, and of the sample after the last.
    first : int
        Position of the first new sample in the span.
    """
    for low in range(0, max(n_samples - 1, 1), SPAN_LENGTH):
        yield low, min(n_samples, low + SPAN_LENGTH + 1), int(low > 0)


def correct_trajectory(
    trajectory: Trajectory,
    partition: Partition,
    constant_factors: Floats,
    e: Floats,
    e_c: Floats,
    suite: Suite,
    fraction: float = 1.0,
) -> Trajectory:
    """Return a copy of a trajectory, corrected by a fraction of the estimated errors.

    The errors of the attitude and of the rotation states (misalignments) are vectors g, twice the
    Gibbs vector. `rotation_matrix(g)` multiplies the rotation from the right. The rotation states
    are constant: their corrected value at the first sample is written to all samples. All other
    errors are added.

    Parameters
    ----------
    trajectory : Trajectory
        Trajectory to correct.
    partition : Partition
        Stochastic and constant states.
    constant_factors : array, shape (N, c)
        Result of `kinematics.compute_constant_factors`.
    e : array, shape (N, d)
        Errors of the stochastic states.
    e_c : array, shape (c,)
        Errors of the constant states.
    suite : Suite
    fraction : float
        Fraction of the errors to apply.

    Returns
    -------
    Trajectory
        New trajectory; the input is unchanged.
    """
    attitude, states = np.empty_like(trajectory.attitude), trajectory.states.copy()
    error = np.zeros(suite.n_states)
    error[partition.constant] = e_c = fraction * e_c
    for low, high, _ in split_into_spans(len(e)):
        samples, errors = slice(low + (low > 0), high), fraction * e[low + (low > 0) : high]
        attitude[samples] = trajectory.attitude[samples] @ np.moveaxis(
            rotation_matrix(errors[:, :3].T), -1, 0
        )
        states[samples, partition.stochastic[3:]] += errors[:, 3:]
        states[samples, partition.constant] += constant_factors[samples] * e_c
    for first in suite.rotation_indices[1:]:  # Misalignments are constant.
        block = slice(first, first + 3)
        states[:, block] = rotation_vector(
            rotation_matrix(trajectory.states[0, block]) @ rotation_matrix(error[block])
        )
    return Trajectory(attitude, states)


#: Largest total memory of the spans that a solution keeps [bytes]. Spans that would need more are
#: computed again when they are used.
MAX_SPAN_MEMORY = 1e9


def compute_sample_memory(suite: Suite, partition: Partition) -> int:
    """Return the memory that the smoother needs per sample [bytes].

    The memory is that of the arrays of a `smoother.Span`: process and measurement equations, filter
    estimates and processed readings. It depends on the numbers of stochastic and constant states,
    the number of sensors, and the largest number of states that influence one sensor's readings.

    Parameters
    ----------
    suite : Suite
    partition : Partition
        Stochastic and constant states.
    """
    d, c, s = len(partition.stochastic), len(partition.constant), len(suite.sensors)
    q, p = (
        d + c,
        max(sum(3 for _ in suite.get_first_indices(sensor)) + 3 for sensor in suite.sensors),
    )
    return 8 * (d * (2 * d + 1) + 3 * c + d * (q + d + 1) + 3 * s * (2 * p + d + q + 2) + c)
