"""Encodings, which convert variables to coordinates of walkers: real vectors or bit strings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mgeo._typing import FloatArray, IntArray
from mgeo.algorithms.variables import Variables

#: Largest number of bits of a variable, so that its integer value is exact as a float.
MAX_BITS = 52


@dataclass(frozen=True, eq=False)
class RealEncoding:
    """Identity encoding, in which the coordinates of a walker are the variables.

    Attributes
    ----------
    variables : Variables
        Variables of the problem.
    """

    variables: Variables

    def draw(self, streams: Sequence[np.random.Generator]) -> FloatArray:
        """Draw a uniform random point within the bounds from each random stream.

        The result has one row per stream.
        """
        xl, xu, is_real = self.variables.xl, self.variables.xu, self.variables.is_real
        unit = np.array([stream.random(len(xl)) for stream in streams]).reshape(-1, len(xl))
        points: FloatArray = np.clip(xl + (xu - xl) * unit, xl, xu)
        if not is_real.all():
            points = np.where(is_real, points, np.minimum(xl + np.floor((xu - xl + 1) * unit), xu))
        return points

    def decode(self, points: FloatArray) -> FloatArray:
        """Return the points unchanged, since their coordinates are the variables."""
        return points

    def encode(self, values: FloatArray) -> FloatArray:
        """Return a copy of the values in which all variables except real ones are rounded."""
        return np.where(self.variables.is_real, values, np.rint(values))


@dataclass(frozen=True, eq=False)
class BitEncoding:
    """Binary encoding that concatenates the bits of all variables.

    The most significant bit of each variable comes first. The b bits of a variable encode a number
    m in 0..2^b - 1. A real variable is xl + (xu - xl) m / (2^b - 1), which includes both bounds, as
    in MGEO.jl. An integer with L levels is xl + floor(m L / 2^b), so that the counts of m per level
    differ by at most one. A choice is treated as an integer.

    Attributes
    ----------
    variables : Variables
        Variables of the problem.
    bits : array of int, shape (n_var,)
        Number of bits of each variable; 0 for an integer with a single level.
    gray : bool
        True if m is encoded as a reflected Gray code, where neighboring numbers differ in one bit.
    positions : array of int, shape (n_var, max(bits))
        Position of each bit in the string. Rows of shorter variables begin with -1.
    """

    variables: Variables
    bits: IntArray
    gray: bool
    positions: IntArray

    @classmethod
    def from_variables(
        cls, variables: Variables, bits: int | Sequence[int], gray: bool
    ) -> BitEncoding:
        """Create a bit encoding with a given number of bits per real variable.

        Parameters
        ----------
        variables : Variables
        bits : int or sequence of int, length n_var
            Number of bits of the real variables. All other variables use the smallest sufficient
            number.
        gray : bool
            True for a reflected Gray code.

        Raises
        ------
        ValueError
            If `bits` has another length, an integer needs more than `MAX_BITS` bits, or the bounds
            fix all variables.
        """
        n_var = len(variables.kinds)
        if np.ndim(bits) and np.size(bits) != n_var:
            raise ValueError(
                f"bits of length {np.size(bits)}: expected one number, or one for each of the "
                f"{n_var} variables"
            )
        spans = variables.xu - variables.xl
        needed = [int(span).bit_length() for span in spans]  # Exact, unlike a logarithm.
        counts = np.where(variables.is_real, bits, needed).astype(np.intp)
        if np.any(counts > MAX_BITS):
            i = int(counts.argmax())
            raise ValueError(
                f"integer variable {variables.format_label(i)} has {int(spans[i]) + 1} levels: "
                f"expected at most 2^{MAX_BITS}"
            )
        if not counts.any():
            raise ValueError("all variables are fixed by their bounds: expected one with xl < xu")
        column = np.arange(counts.max())[None, :] - (counts.max() - counts[:, None])
        first = np.cumsum(counts) - counts
        positions = np.where(column >= 0, first[:, None] + column, -1)
        return cls(variables, counts, gray, positions)

    @property
    def length(self) -> int:
        """Total number of bits that encode a design."""
        return int(self.bits.sum())

    def draw(self, streams: Sequence[np.random.Generator]) -> FloatArray:
        """Draw a random bit string from each random stream.

        The result has one row of zeros and ones per stream.
        """
        strings = [stream.integers(0, 2, self.length) for stream in streams]
        return np.array(strings, dtype=float).reshape(-1, self.length)

    def decode(self, strings: FloatArray) -> FloatArray:
        """Convert bit strings to the values of the variables.

        Parameters
        ----------
        strings : array, shape (..., length)
            Bits 0 and 1.

        Returns
        -------
        array, shape (..., n_var)
        """
        # A reshape is several times faster, if all variables have the same number of bits.
        if self.positions.min() >= 0:
            digits = strings.reshape(*strings.shape[:-1], *self.positions.shape)
        else:
            digits = np.where(self.positions >= 0, strings[..., self.positions], 0.0)
        if self.gray:
            digits = np.cumsum(digits, axis=-1) % 2.0
        m = digits @ self._compute_bit_weights()
        xl, xu = self.variables.xl, self.variables.xu
        count = 2.0**self.bits
        fraction = m / np.maximum(count - 1.0, 1.0)
        level = np.floor(m * (xu - xl + 1.0) / count)
        is_real = self.variables.is_real
        decoded: FloatArray = np.where(is_real, xl + (xu - xl) * fraction, xl + level)
        return np.clip(decoded, xl, xu)

    def encode(self, values: FloatArray) -> FloatArray:
        """Convert the values of the variables to bit strings.

        Each value is rounded to the nearest value that its bits can represent.

        Parameters
        ----------
        values : array, shape (..., n_var)
            Variables within the bounds.

        Returns
        -------
        array, shape (..., length)
        """
        xl, xu = self.variables.xl, self.variables.xu
        count = 2.0**self.bits
        width = np.where(xu > xl, xu - xl, 1.0)
        m = np.where(
            self.variables.is_real,
            np.rint((values - xl) / width * (count - 1.0)),
            np.ceil((np.rint(values) - xl) * count / (xu - xl + 1.0)),
        )
        digits = np.floor(m[..., None] / self._compute_bit_weights()) % 2.0
        if self.gray:
            digits[..., 1:] = (digits[..., 1:] + digits[..., :-1]) % 2.0
        return digits[..., self.positions >= 0]

    def _compute_bit_weights(self) -> FloatArray:
        return 2.0 ** np.arange(self.positions.shape[1] - 1, -1, -1)
