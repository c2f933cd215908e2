"""Hypervolume of a front with the reference point (1, ..., 1)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from pymoo.indicators.hv import HV

from mgeo._typing import FloatArray
from mgeo.plugins.protocol import get_indicator_map

if TYPE_CHECKING:
    from pymoo.core.problem import Problem

#: Maximum number of objectives, because the computation time grows exponentially: for 300 points,
#: 1 ms with 5 objectives and a minute with 8.
MAX_OBJECTIVES = 5


def compute_hypervolume(problem: Problem, F: ArrayLike) -> float | None:
    """Return the hypervolume of a front in the indicator space of its problem.

    Parameters
    ----------
    problem
        Problem of the front.
    F
        Objectives, shape (n, n_obj).

    Returns
    -------
    float or None
        None if the problem has no indicator space, one objective, or more than `MAX_OBJECTIVES`.
    """
    space = get_indicator_map(problem)
    if space is None or not 1 < problem.n_obj <= MAX_OBJECTIVES:
        return None
    front = np.asarray(F, dtype=float)
    return compute_unit_hypervolume(space(front)) if len(front) else 0.0


def compute_unit_hypervolume(points: FloatArray) -> float:
    """Return the volume that points, shape (n, m), dominate up to (1, ..., 1)."""
    return float(HV(ref_point=np.ones(points.shape[1]))(points))


def scale_objectives(F: FloatArray, ideal: FloatArray, nadir: FloatArray) -> FloatArray:
    """Scale objectives linearly so that `ideal` maps to 0 and `nadir` to 1.

    Objectives with equal ideal and nadir are only shifted.

    Parameters
    ----------
    F
        Objectives, shape (n, n_obj).
    ideal, nadir
        Points of shape (n_obj,).
    """
    extent = nadir - ideal
    return (F - ideal) / np.where(extent > 0, extent, 1.0)
