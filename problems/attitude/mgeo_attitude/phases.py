"""The phases of a plan as flown: its maneuvers, then the time for which the last rate is held."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .filter.timeline import VARIABLES_PER_MANEUVER, flown

HELD = "rate held"


@dataclass(frozen=True)
class Phase:
    """A stretch of constant body rate.

    Attributes
    ----------
    label : str
        ``maneuver 2``, numbered as in the design, or ``rate held``.
    start, end : float
        [s] after the epoch.
    rates_deg_s : tuple of three floats
        About body x, y and z.
    """

    label: str
    start: float
    end: float
    rates_deg_s: tuple[float, float, float]

    @property
    def duration(self) -> float:
        """[s]"""
        return self.end - self.start

    @property
    def swept_deg(self) -> float:
        """Angle turned through [deg]."""
        return float(np.linalg.norm(self.rates_deg_s)) * self.duration


def phases(design: ArrayLike, t_end: float, step: float) -> tuple[Phase, ...]:
    """Phases of one design, shape (4 m,), up to `t_end`, as `filter.timeline.flown` has them.

    Maneuvers shorter than a step may be left out. No rate is held where the run ends with the last
    maneuver.
    """
    flight = flown(design, t_end, step)
    held = flight.over < t_end
    # not the flight's rates, which went through radians
    table = np.asarray(design, dtype=float).reshape(-1, VARIABLES_PER_MANEUVER)[flight.numbers]
    found = []
    for number, (*rate, _), start, end in zip(
        flight.numbers, table, flight.times, flight.times[1:], strict=False
    ):
        last = held and end == t_end
        x, y, z = (float(component) for component in rate)
        stop = flight.over if last else float(end)
        if stop > start:  # the last of the design may be over before its first step
            found.append(Phase(f"maneuver {number + 1}", float(start), stop, (x, y, z)))
        if last:
            found.append(Phase(HELD, stop, float(end), (x, y, z)))
    return tuple(found)
