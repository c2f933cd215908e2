"""In which steps a channel counts."""

from __future__ import annotations

import numpy as np
from mgeo_attitude._typing import Floats

_FEWEST = 20  # samples that can tell
_SAME = 1e-7  # numbers that differ by this share of a large one are one that was rounded
_MOST = 0.9  # share of numbers that are not larger than that
_OFF = 0.05  # how far a difference may be from a multiple of the step, in steps
_REGULAR = 0.99  # share of differences that are not farther
_PARTS = 25  # steps in the smallest difference, at most
_RESTS = 5  # numbers that do not say much of a step


def resolution(values: Floats) -> Floats:
    """The step of each channel, zero of one whose numbers are no multiples of one.

    A channel that rests at a few numbers, of which its step hardly follows, counts as the finest.

    Parameters
    ----------
    values : array, shape (n, k)
        Rows of NaN are no samples.
    """
    rows = values[np.isfinite(values).all(axis=1)]
    if len(rows) < _FEWEST:
        return np.zeros(values.shape[1])
    steps = np.array([_step(channel) for channel in rows.T])
    counted = steps > 0.0
    rests = [len(np.unique(channel)) <= _RESTS for channel in rows.T]
    steps[rests] = steps.min(where=counted, initial=np.inf) if counted.any() else 0.0
    return np.where(np.isfinite(steps), steps, 0.0)


def _step(channel: Floats) -> float:
    """Zero if numbers hardly repeat and are no multiples; not finite if they do and do not say."""
    apart = np.diff(np.sort(channel))
    apart = apart[apart > _SAME * np.quantile(np.abs(channel), _MOST)]  # few may be absurd
    repeat = 2 * len(apart) <= len(channel)
    for parts in range(1, _PARTS if repeat else 2) if len(apart) else ():
        multiples = np.rint(apart / apart.min() * parts)
        step = float(apart @ multiples / (multiples @ multiples))
        if (np.abs(apart / step - multiples) < _OFF).mean() > _REGULAR:
            return step
    return np.nan if repeat else 0.0
