"""Vector-valued Taylor polynomials of second order in the errors of an estimate.

A sensor model that is written with ``+ - * /``, `rotate`, `cross`, `dot` and `direction` can be
evaluated on these polynomials. The result contains the value of the model and its exact first and
second derivatives, for many runs at once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.rotation import multiply, skew

#: Numbers of the error 3-vectors of a term. The term (i, j) represents Σ T[p, q] e_i[p] e_j[q].
Term = tuple[int, ...]


class TaylorPolynomial:
    """Second-order Taylor polynomial of a vector in the estimation errors, for r filter runs at
    once.

    A sensor model treats the polynomial as an array of shape (r, d). The error 3-vectors are
    numbered. A term (i, j) is bilinear in the error 3-vectors i and j.

    Attributes
    ----------
    terms : mapping of Term to array, shape (d, 3**degree, r)
        Coefficients. Missing terms are zero. A term that is equal in all runs may have r = 1.
    """

    #: Highest degree; terms of a higher degree are dropped.
    order: ClassVar[int] = 2

    __array_ufunc__ = None  # NumPy then defers to the operators of this class.

    def __init__(self, terms: Mapping[Term, Floats]) -> None:
        self.terms = terms

    def map(self, linear: Callable[[Floats], Floats]) -> TaylorPolynomial:
        """Apply a linear function along the first axis of each coefficient array, and return the
        new polynomial.
        """
        return type(self)({term: linear(part) for term, part in self.terms.items()})

    @classmethod
    def from_value(cls, value: Any) -> TaylorPolynomial:
        """Convert a number or an array of shape (d,) or (r, d) to a constant polynomial.

        A polynomial is returned unchanged.
        """
        if isinstance(value, TaylorPolynomial):
            return value
        return cls({(): np.atleast_2d(value).T[:, None]})

    @property
    def value(self) -> Floats:
        """Value of the polynomial at zero errors, shape (d, r)."""
        return self.terms[()][:, 0]

    def __getitem__(self, index: Any) -> TaylorPolynomial:
        """Return the polynomial of the selected vector components, as in ``p[..., [1, 2, 0]]``."""
        return self.map(lambda part: part[index[-1]])

    def __neg__(self) -> TaylorPolynomial:
        return self.map(np.negative)

    def __add__(self, other: Any) -> TaylorPolynomial:
        total = dict(self.terms)
        for term, part in self.from_value(other).terms.items():
            total[term] = total[term] + part if term in total else part
        return type(self)(total)

    def __sub__(self, other: Any) -> TaylorPolynomial:
        return self + -self.from_value(other)

    def __rsub__(self, other: Any) -> TaylorPolynomial:
        return self.from_value(other) - self

    def __mul__(self, other: Any) -> TaylorPolynomial:
        factors, total = self.from_value(other).terms, dict[Term, Floats]()
        for a, p in self.terms.items():
            for b, q in factors.items():
                if len(a) + len(b) <= self.order:
                    product = _multiply_terms(p, q) if a and b else p * q
                    total[a + b] = total[a + b] + product if a + b in total else product
        return type(self)(total)

    def sqrt(self) -> TaylorPolynomial:
        root = np.sqrt(self.terms[()])
        rest = type(self)({t: part / self.terms[()] for t, part in self.terms.items() if t})
        return (1.0 + 0.5 * rest - 0.125 * (rest * rest)).map(lambda part: part * root)

    def __truediv__(self, other: Any) -> TaylorPolynomial:
        other = self.from_value(other)
        reciprocal = 1.0 / other.terms[()]
        rest = type(self)({t: part * reciprocal for t, part in other.terms.items() if t})
        return self * (1.0 - rest + rest * rest).map(lambda part: part * reciprocal)

    def __rtruediv__(self, other: Any) -> TaylorPolynomial:
        return self.from_value(other) / self

    __radd__, __rmul__ = __add__, __mul__


class LinearPolynomial(TaylorPolynomial):
    """Taylor polynomial of first order: the value and its first derivatives."""

    order = 1


class ConstantPolynomial(TaylorPolynomial):
    """Taylor polynomial of order zero: the value without derivatives."""

    order = 0


def _multiply_terms(p: Floats, q: Floats) -> Floats:
    outer = p[:, :, None] * q[:, None]
    return outer.reshape(len(outer), -1, outer.shape[-1])


def add_error(
    vector: Floats, number: int, kind: type[TaylorPolynomial] = TaylorPolynomial
) -> TaylorPolynomial:
    """Add an unknown error to a 3-vector, and return the sum as a Taylor polynomial in the error.

    Parameters
    ----------
    vector : array, shape (r, 3)
        Vector of each run.
    number : int
        Number of the error 3-vector.
    kind : type
        `TaylorPolynomial`, `LinearPolynomial` or `ConstantPolynomial`.

    Returns
    -------
    TaylorPolynomial
    """
    constant = kind.from_value(vector)
    return kind({**constant.terms, (number,): np.eye(3)[:, :, None]}) if kind.order else constant


def build_rotation_with_error(
    rotation: Floats | None,
    number: int,
    sign: float = 1.0,
    kind: type[TaylorPolynomial] = TaylorPolynomial,
) -> Callable[[Any], TaylorPolynomial]:
    """Return a function that rotates a vector by an uncertain rotation. The rotated vector is a
    Taylor polynomial in the rotation error.

    The function computes R R(±e) v. R(g) v is expanded to second order: v + g × v + ½ g × (g × v)
    for g = ±e.

    Parameters
    ----------
    rotation : array, shape (3, 3, r), optional
        Rotation matrix R of each run. None for the identity.
    number : int
        Number of the error 3-vector.
    sign : float
        Sign of e.
    kind : type
        `TaylorPolynomial`, `LinearPolynomial` or `ConstantPolynomial`.

    Returns
    -------
    function
        Function from an array or a polynomial v to the polynomial of the rotated vector.
    """

    def cross_error(terms: Mapping[Term, Floats], factor: float) -> dict[Term, Floats]:
        product = {}
        for term, part in terms.items():
            if len(term) < kind.order:
                rotated = skew(-factor * part)
                product[number, *term] = rotated.reshape(3, -1, part.shape[-1])
        return product

    def rotate(v: Any) -> TaylorPolynomial:
        vector = kind.from_value(v)
        first_order = cross_error(vector.terms, sign)
        second_order = cross_error(
            {t: part for t, part in first_order.items() if len(t) == 1}, 0.5 * sign
        )
        rotated = vector + kind(first_order) + kind(second_order)
        return rotated if rotation is None else rotated.map(lambda part: multiply(rotation, part))

    return rotate
