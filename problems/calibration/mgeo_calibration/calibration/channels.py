"""Other columns of telemetry that biases may follow: those that are asked."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mgeo_attitude._typing import Floats

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.residuals import Innovations
from mgeo_calibration.telemetry import Telemetry

_MOST = 4  # each has a question for gyro and every sensor


def channels_of(
    telemetry: Telemetry, data: Batch, innovations: Sequence[Innovations]
) -> tuple[dict[str, Floats], int]:
    """The `_MOST` channels that innovations follow most, at the samples; how many others."""
    found = {}
    for name, values in telemetry.others.items():
        channel = np.interp(data.times, telemetry.times, values)
        if np.ptp(channel) > 0.0:
            scaled = (channel - channel.mean()) / channel.std()
            told = sum(
                float(np.square(scaled[each.samples] @ each.whitened).sum())
                / max(len(each.samples), 1)
                for each in innovations
            )
            found[name] = told, channel
    most = sorted(found, key=lambda name: -found[name][0])[:_MOST]
    return {name: found[name][1] for name in most}, len(found) - len(most)
