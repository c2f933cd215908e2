"""How wheels share a torque, or momentum, about the body axes: what the most loaded one takes.

With the spin axes of n wheels as columns of A their torques u, or momenta, make A u in body axes.
With more than three wheels many u do. What the most loaded wheel takes is, for both rules here, the
greatest |W m| of a matrix W, shape (k, 3), for a demand m.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from mgeo_attitude._typing import Floats

#: Sine of the angle between two axes that span no plane.
_PARALLEL = 1e-9


def pseudo_inverse(axes: Floats) -> Floats:
    """W of the u of least sum of squares, A⁺ = Aᵀ (A Aᵀ)⁻¹: one row a wheel, shape (n, 3).

    Parameters
    ----------
    axes : array, shape (n, 3)
        Spin axes, unit vectors, in body axes, that span all directions.
    """
    return np.asarray(np.linalg.solve(axes.T @ axes, axes.T).T)


def minimax(axes: Floats) -> Floats:
    """W of the u whose greatest component is least: one row a pair of wheels, shape (k, 3).

    What n wheels of one size reach together, {A u: |u| <= 1}, is a zonotope. Its facets are spanned
    by pairs of axes, and a demand m exceeds the one with the normal n by |n · m| / Σ |n · a|. The
    greatest of these is the least size that reaches m (Markley, Reynolds, Liu, Lebsock, Maximum
    Torque and Momentum Envelopes for Reaction-Wheel Arrays, Journal of Guidance, Control, and
    Dynamics 33 (2010) 1606-1614).

    Parameters
    ----------
    axes
        As of `pseudo_inverse`.
    """
    normals = np.array([np.cross(a, b) for a, b in combinations(axes, 2)])
    normals = normals[np.linalg.norm(normals, axis=1) > _PARALLEL]
    return np.asarray(normals / np.abs(normals @ axes.T).sum(axis=1, keepdims=True))


#: Rules by the ``allocation`` that names them in a scenario file.
ALLOCATIONS = {"pseudo-inverse": pseudo_inverse, "minimax": minimax}
