"""Vectors as Taylor polynomials of second order in the errors of an estimate.

Evaluated on them, a sensor's model in ``+ - * /``, `rotate`, `cross`, `dot` and `direction` gives
its value and its exact first and second derivatives, for many runs at once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.rotation import multiply, skew

#: The errors are 3-vectors with numbers. A term (i, j) stands for Σ T[p, q] e_i[p] e_j[q].
Term = tuple[int, ...]


class Taylor:
    """A vector of d components in r runs, a polynomial of second order in error 3-vectors.

    In a model it stands for an array of shape (r, d).

    Attributes
    ----------
    terms : mapping of Term to array, shape (d, 3**degree, r)
        What is left out is zero. What is the same in all runs may have r = 1.
    """

    #: Terms of a higher one are left out.
    order: ClassVar[int] = 2

    __array_ufunc__ = None  # an array leaves it to this class how both are combined

    def __init__(self, terms: Mapping[Term, Floats]) -> None:
        self.terms = terms

    def map(self, linear: Callable[[Floats], Floats]) -> Taylor:
        """A linear function of the components, applied to the first axis of every term."""
        return type(self)({term: linear(part) for term, part in self.terms.items()})

    @classmethod
    def of(cls, value: Any) -> Taylor:
        """A constant: a number or an array, shape (d,) or (r, d)."""
        if isinstance(value, Taylor):
            return value
        return cls({(): np.atleast_2d(value).T[:, None]})

    @property
    def value(self) -> Floats:
        """Its value without errors, shape (d, r)."""
        return self.terms[()][:, 0]

    def __getitem__(self, index: Any) -> Taylor:
        """Components, ``[..., [1, 2, 0]]``."""
        return self.map(lambda part: part[index[-1]])

    def __neg__(self) -> Taylor:
        return self.map(np.negative)

    def __add__(self, other: Any) -> Taylor:
        total = dict(self.terms)
        for term, part in self.of(other).terms.items():
            total[term] = total[term] + part if term in total else part
        return type(self)(total)

    def __sub__(self, other: Any) -> Taylor:
        return self + -self.of(other)

    def __rsub__(self, other: Any) -> Taylor:
        return self.of(other) - self

    def __mul__(self, other: Any) -> Taylor:
        factors, total = self.of(other).terms, dict[Term, Floats]()
        for a, p in self.terms.items():
            for b, q in factors.items():
                if len(a) + len(b) <= self.order:
                    product = _outer(p, q) if a and b else p * q
                    total[a + b] = total[a + b] + product if a + b in total else product
        return type(self)(total)

    def sqrt(self) -> Taylor:
        root = np.sqrt(self.terms[()])
        rest = type(self)({t: part / self.terms[()] for t, part in self.terms.items() if t})
        return (1.0 + 0.5 * rest - 0.125 * (rest * rest)).map(lambda part: part * root)

    def __truediv__(self, other: Any) -> Taylor:
        other = self.of(other)
        reciprocal = 1.0 / other.terms[()]
        rest = type(self)({t: part * reciprocal for t, part in other.terms.items() if t})
        return self * (1.0 - rest + rest * rest).map(lambda part: part * reciprocal)

    def __rtruediv__(self, other: Any) -> Taylor:
        return self.of(other) / self

    __radd__, __rmul__ = __add__, __mul__


class Linear(Taylor):
    """Of first order alone: value and derivative."""

    order = 1


def _outer(p: Floats, q: Floats) -> Floats:
    """Products of terms of first order, of each component, as a term of second order."""
    outer = p[:, :, None] * q[:, None]
    return outer.reshape(len(outer), -1, outer.shape[-1])


def uncertain(vector: Floats, number: int, kind: type[Taylor] = Taylor) -> Taylor:
    """A vector, shape (r, 3), whose error is the 3-vector of a number."""
    return kind({**kind.of(vector).terms, (number,): np.eye(3)[:, :, None]})


def uncertain_rotation(
    known: Floats | None, number: int, sign: float = 1.0, kind: type[Taylor] = Taylor
) -> Callable[[Any], Taylor]:
    """R R(±e) for a known matrix, shape (3, 3, r) or None for I, and the error of a number.

    R (v + g × v + ½ g × (g × v)) for g = ±e: what is left out is of third order.
    """

    def cross_error(terms: Mapping[Term, Floats], factor: float) -> dict[Term, Floats]:
        """factor e × v for the terms of v, to second order."""
        product = {}
        for term, part in terms.items():
            if len(term) < kind.order:
                turned = skew(-factor * part)
                product[number, *term] = turned.reshape(3, -1, part.shape[-1])
        return product

    def rotate(v: Any) -> Taylor:
        vector = kind.of(v)
        once = cross_error(vector.terms, sign)
        twice = cross_error({t: part for t, part in once.items() if len(t) == 1}, 0.5 * sign)
        turned = vector + kind(once) + kind(twice)
        return turned if known is None else turned.map(lambda part: multiply(known, part))

    return rotate
