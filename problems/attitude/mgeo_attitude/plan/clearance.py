"""How near the Sun comes to what must stay off it while a plan slews back."""

from __future__ import annotations

import numpy as np

from .._typing import Floats
from ..environment.pointing import Place
from ..filter.keep_out import sun_clearance
from ..scenario import Scenario


def sun_in_slew_back(
    scenario: Scenario, times: Floats, attitude: Floats, covariance: Floats
) -> Floats:
    """Least clearance of each keep-out cone [rad], shape (n_cones,), at most π.

    The attitude is as well known as at the end of the filter's run.

    Parameters
    ----------
    times : array, shape (n,)
        [s] after the epoch.
    attitude : array, shape (n, 3, 3)
        GCRS to body then.
    covariance : array, shape (3, 3)
        Of the attitude error at the end of the run, body axes [rad²].
    """
    at = Place.at(scenario, times)
    shining = at.sunlit | (not scenario.eclipse)
    sun = np.einsum("kij,kj->ki", attitude, at.sun) * shining[:, None]
    known = np.repeat(covariance[None], len(times), axis=0)
    least = [
        sun_clearance(np.array(cone.axis()), cone.attitude_sigmas, sun, known).min()
        for cone in scenario.keep_outs
    ]
    clearance: Floats = np.minimum(np.array(least), np.pi)
    return clearance
