"""What a calibration takes of memory, before it begins."""

from __future__ import annotations

import os

from mgeo_attitude.sensors import Suite

from mgeo_calibration.estimation.trajectory import Partition


def physical() -> float | None:
    """Of this machine [bytes]; None where it is not told."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):
        return None


#: Spans are kept as long as all of them take so much memory, and not formed again [bytes].
KEPT = max(400e6, 0.1 * (physical() or 0.0))
#: What is there without any sample: packages, and spans that are formed [bytes].
FIXED = 400e6
#: From so much on it is told beforehand [bytes].
LARGE = 1e9
#: Arrays of the trajectory that are there at once, and of three numbers of each sensor.
_TRAJECTORIES, _READINGS = 3, 6
#: Of a sample else: times, rates, attitudes of filter and smoother, their table as text [bytes].
_ROW = 700


def needed(suite: Suite, rows: int) -> float:
    """Memory that so many samples take [bytes]; the most that was measured is less.

    Where not all spans are kept, those of a stretch that a fit begins with may be.
    """
    row = _ROW + 8 * (_TRAJECTORIES * (9 + suite.n_states) + 3 * _READINGS * len(suite.sensors))
    held = row_bytes(suite, Partition.of(suite)) * rows
    return FIXED + row * rows + min(held, KEPT)


def row_bytes(suite: Suite, parts: Partition) -> int:
    """What a sample takes in a `Span`."""
    d, c, s = len(parts.driven), len(parts.constant), len(suite.sensors)
    q, p = d + c, max(sum(3 for _ in suite.places(sensor)) + 3 for sensor in suite.sensors)
    return 8 * (d * (2 * d + 1) + 3 * c + d * (q + d + 1) + 3 * s * (2 * p + d + q + 2) + c)


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
