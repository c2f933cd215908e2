"""Estimates at all samples, spans in which they are treated, and the memory that both take."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.geometry.rotation import matrix, rotation_vector
from mgeo_attitude.sensors.suite import Suite

#: Samples whose equations are formed at once: those of all would need much memory.
SPAN = 2000


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Estimates at N samples.

    Attributes
    ----------
    attitude : array, shape (N, 3, 3)
        Body to GCRS.
    states : array, shape (N, n_states)
        Of gyro and sensors, rotations as vectors; zero for the attitude. Those that nothing drives
        follow from those at the first sample.
    """

    attitude: Floats
    states: Floats

    def part(self, low: int, high: int) -> Trajectory:
        """Samples low to high - 1."""
        return Trajectory(self.attitude[low:high], self.states[low:high])


@dataclass(frozen=True, eq=False)
class Partition:
    """Which states are estimated at every sample, and which once.

    Attributes
    ----------
    driven : array of int, shape (d,)
        Those that noise drives: the attitude, mostly the gyro's bias, and processes of sensors.
    constant : array of int, shape (c,)
        All others; what is estimated is their value at the first sample.
    """

    driven: Ints
    constant: Ints

    @classmethod
    def of(cls, suite: Suite) -> Partition:
        """By the diffusion of the dynamic states; that of the attitude is not zero."""
        driven = np.flatnonzero(suite.diffusion() > 0.0)
        return cls(driven, np.setdiff1d(np.arange(suite.n_states), driven))


def spans(n: int) -> Iterator[tuple[int, int, int]]:
    """Parts of n samples, low to high - 1, and which of them is the first that is new.

    Each begins with the last of the one before: so it has all steps to the samples that are new.
    """
    for low in range(0, max(n - 1, 1), SPAN):
        yield low, min(n, low + SPAN + 1), int(low > 0)


def moved(at: Trajectory, parts: Partition, growth: Floats, e: Floats, e_c: Floats,
          suite: Suite, share: float = 1.0) -> Trajectory:  # fmt: skip
    """A trajectory with a share of errors taken out: driven ones e, shape (N, d), constant e_c."""
    attitude, states = np.empty_like(at.attitude), at.states.copy()
    error = np.zeros(suite.n_states)
    error[parts.constant] = e_c = share * e_c
    for low, high, _ in spans(len(e)):
        own, off = slice(low + (low > 0), high), share * e[low + (low > 0) : high]
        attitude[own] = at.attitude[own] @ np.moveaxis(matrix(off[:, :3].T), -1, 0)
        states[own, parts.driven[3:]] += off[:, 3:]
        states[own, parts.constant] += growth[own] * e_c
    for first in suite.rotations[1:]:  # of which none is driven, or decays
        block = slice(first, first + 3)
        states[:, block] = rotation_vector(matrix(at.states[0, block]) @ matrix(error[block]))
    return Trajectory(attitude, states)


#: Spans are kept, and not formed again, as long as all of them take less memory [bytes].
KEPT = 1e9


def row_bytes(suite: Suite, parts: Partition) -> int:
    """What a sample takes in a `Span`."""
    d, c, s = len(parts.driven), len(parts.constant), len(suite.sensors)
    q, p = d + c, max(sum(3 for _ in suite.places(sensor)) + 3 for sensor in suite.sensors)
    return 8 * (d * (2 * d + 1) + 3 * c + d * (q + d + 1) + 3 * s * (2 * p + d + q + 2) + c)
