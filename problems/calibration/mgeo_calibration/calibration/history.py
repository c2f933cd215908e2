"""What a calibration knows of every sample."""

from __future__ import annotations

from dataclasses import dataclass

from mgeo_attitude._typing import Floats

from mgeo_calibration.estimation.residuals import Innovations


@dataclass(frozen=True, eq=False, kw_only=True)
class History:
    """Attitude at N samples, and innovations.

    Attributes
    ----------
    times : array, shape (N,)
        [s]
    smoothed, filtered : arrays, shape (N, 3, 3)
        GCRS to body: by all readings, and by those until the sample.
    smoothed_sigma, filtered_sigma : arrays, shape (N, 3)
        1-sigma about the body axes [rad].
    innovations : tuple of Innovations
        One a sensor.
    """

    times: Floats
    smoothed: Floats
    smoothed_sigma: Floats
    filtered: Floats
    filtered_sigma: Floats
    innovations: tuple[Innovations, ...]
