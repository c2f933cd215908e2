"""Perturbations: how far a candidate may step from its walker."""

from collections.abc import Callable

import numpy as np

from mgeo._typing import FloatArray

Scale = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]


def absolute(x: FloatArray, xl: FloatArray, xu: FloatArray) -> FloatArray:
    """Unit scale: sigma is the standard deviation in the variable's own unit."""
    return np.ones_like(x)


def relative(x: FloatArray, xl: FloatArray, xu: FloatArray) -> FloatArray:
    """The value itself: sigma is a fraction of it. A variable at zero stays there."""
    return x


def of_range(x: FloatArray, xl: FloatArray, xu: FloatArray) -> FloatArray:
    """The width of the bounds: sigma is a fraction of it, whatever the unit."""
    return np.broadcast_to(xu - xl, x.shape)


SCALES: dict[str, Scale] = {"absolute": absolute, "relative": relative, "range": of_range}


def perturb(
    x: FloatArray,
    noise: FloatArray,
    sigma: float | FloatArray,
    scale: Scale,
    xl: FloatArray,
    xu: FloatArray,
) -> FloatArray:
    """New value of every variable, clipped to its bounds.

    x + sigma scale(x) N(0, 1) (Mainenti-Lopes, Souza & de Sousa 2012); equation (9) of
    docs/theory.md.

    Parameters
    ----------
    x : (n_walkers, n_var) where the walkers stand.
    noise : (n_walkers, n_var) standard normal draws.
    sigma : standard deviation, one for all or (n_var,).
    scale : what sigma is a multiple of: one of `SCALES`.
    xl, xu : (n_var,) bounds.

    Returns
    -------
    (n_walkers, n_var) values, of which a candidate takes one.
    """
    return np.clip(x + sigma * scale(x, xl, xu) * noise, xl, xu)
