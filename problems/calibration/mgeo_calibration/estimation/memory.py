"""What a calibration takes of memory, before it begins."""

from __future__ import annotations

import os

from mgeo_attitude.sensors.suite import Suite

from mgeo_calibration.estimation.smoother import KEPT

#: What is there without any sample: packages, and spans that are kept or formed [bytes].
FIXED = 350e6 + KEPT
#: From so much on it is told beforehand [bytes].
LARGE = 1e9
#: Arrays of the trajectory that are there at once, and of three numbers of each sensor.
_TRAJECTORIES, _READINGS = 3, 6
#: Of a sample else: times, rates, attitudes of filter and smoother, their table as text [bytes].
_ROW = 700


def needed(suite: Suite, rows: int) -> float:
    """Memory that so many samples take [bytes]; the most that was measured is less."""
    row = _ROW + 8 * (_TRAJECTORIES * (9 + suite.n_states) + 3 * _READINGS * len(suite.sensors))
    return FIXED + row * rows


def physical() -> float | None:
    """Of this machine [bytes]; None where it is not told."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):
        return None


def told(suite: Suite, rows: int) -> str | None:
    """That in words, if it is large.

    Raises
    ------
    ValueError
        If this machine has less.
    """
    size, there = needed(suite, rows), physical()
    words = f"{rows:,} samples take about {size / 1e9:.2g} GB of memory"
    if there is not None and size > there:
        raise ValueError(
            f"{words}, and this machine has {there / 1e9:.2g} GB: expected a shorter time, or "
            "fewer samples, with rates that are means over longer steps"
        )
    return words if size > LARGE else None
