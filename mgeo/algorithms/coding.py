"""Walkers as what they stand for: variables themselves, or strings of bits, plain or Gray."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mgeo._typing import FloatArray, IntArray
from mgeo.algorithms.variables import Variables

MOST_BITS = 52  # of one variable: its number is exact in a float


@dataclass(frozen=True, eq=False)
class RealCode:
    """Walkers that are the variables themselves."""

    variables: Variables

    def draw(self, streams: Sequence[np.random.Generator]) -> FloatArray:
        """(n, n_var) a point from each of n streams, uniform within the bounds."""
        xl, xu, real = self.variables.xl, self.variables.xu, self.variables.real
        unit = np.array([stream.random(len(xl)) for stream in streams]).reshape(-1, len(xl))
        points: FloatArray = np.clip(xl + (xu - xl) * unit, xl, xu)
        if not real.all():
            points = np.where(real, points, np.minimum(xl + np.floor((xu - xl + 1) * unit), xu))
        return points

    def decode(self, points: FloatArray) -> FloatArray:
        """The points themselves."""
        return points

    def encode(self, values: FloatArray) -> FloatArray:
        """The values themselves, whole numbers unless real."""
        return np.where(self.variables.real, values, np.rint(values))


@dataclass(frozen=True, eq=False)
class BitCode:
    """How a string of bits is read, variable after variable, the highest bit first.

    b bits are a number m in 0..2^b - 1. A real variable is xl + (xu - xl) m / (2^b - 1), both
    bounds included, as in MGEO.jl; an integer of L levels is xl + floor(m L / 2^b), so that every
    level has as many numbers as the others, or one more. Neighboring numbers differ in one bit
    if `gray`.

    Attributes
    ----------
    variables : of the problem.
    bits : (n_var,) bits of each; 0 for an integer of one level. A choice is an integer.
    gray : whether m is read as a reflected Gray code.
    places : (n_var, max bits) where each bit stands in the string, -1 (leading) for none.
    """

    variables: Variables
    bits: IntArray
    gray: bool
    places: IntArray

    @classmethod
    def of(cls, variables: Variables, bits: int | Sequence[int], gray: bool) -> BitCode:
        """The code for some variables.

        `bits` is for each real variable, one number for all or one per variable; the others have
        as many as their levels need. ValueError if that cannot be.
        """
        n_var = len(variables.kinds)
        if np.ndim(bits) and np.size(bits) != n_var:
            raise ValueError(
                f"bits of length {np.size(bits)}: expected one number, or one for each of the "
                f"{n_var} variables"
            )
        spans = variables.xu - variables.xl
        own = [int(span).bit_length() for span in spans]  # a logarithm is not exact
        counts = np.where(variables.real, bits, own).astype(np.intp)
        if np.any(counts > MOST_BITS):
            i = int(counts.argmax())
            raise ValueError(
                f"integer variable {variables.label(i)} has {int(spans[i]) + 1} levels: expected "
                f"at most 2^{MOST_BITS}"
            )
        if not counts.any():
            raise ValueError("all variables are fixed by their bounds: expected one that is not")
        column = np.arange(counts.max())[None, :] - (counts.max() - counts[:, None])
        first = np.cumsum(counts) - counts
        places = np.where(column >= 0, first[:, None] + column, -1)
        return cls(variables, counts, gray, places)

    @property
    def length(self) -> int:
        """Bits of the whole string."""
        return int(self.bits.sum())

    def draw(self, streams: Sequence[np.random.Generator]) -> FloatArray:
        """(n, length) a string from each of n streams."""
        strings = [stream.integers(0, 2, self.length) for stream in streams]
        return np.array(strings, dtype=float).reshape(-1, self.length)

    def decode(self, strings: FloatArray) -> FloatArray:
        """(..., n_var) values of strings of 0 and 1, (..., length)."""
        if self.places.min() >= 0:  # all of one length: several times faster
            digits = strings.reshape(*strings.shape[:-1], *self.places.shape)
        else:
            digits = np.where(self.places >= 0, strings[..., self.places], 0.0)
        if self.gray:
            digits = np.cumsum(digits, axis=-1) % 2.0
        m = digits @ self._weights()
        xl, xu = self.variables.xl, self.variables.xu
        count = 2.0**self.bits
        share = m / np.maximum(count - 1.0, 1.0)
        whole = np.floor(m * (xu - xl + 1.0) / count)
        decoded: FloatArray = np.where(self.variables.real, xl + (xu - xl) * share, xl + whole)
        return np.clip(decoded, xl, xu)

    def encode(self, values: FloatArray) -> FloatArray:
        """(..., length) string nearest to each vector of values, (..., n_var)."""
        xl, xu = self.variables.xl, self.variables.xu
        count = 2.0**self.bits
        width = np.where(xu > xl, xu - xl, 1.0)
        m = np.where(
            self.variables.real,
            np.rint((values - xl) / width * (count - 1.0)),
            np.ceil((np.rint(values) - xl) * count / (xu - xl + 1.0)),
        )
        digits = np.floor(m[..., None] / self._weights()) % 2.0
        if self.gray:
            digits[..., 1:] = (digits[..., 1:] + digits[..., :-1]) % 2.0
        return digits[..., self.places >= 0]

    def _weights(self) -> FloatArray:
        return 2.0 ** np.arange(self.places.shape[1] - 1, -1, -1)
