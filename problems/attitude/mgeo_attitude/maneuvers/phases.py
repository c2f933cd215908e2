"""The phases of a plan as flown: ramps, maneuvers, then the time the last rate is held."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .schedule import VARIABLES_PER_MANEUVER, flown
from .slew import SlewLimits

HELD = "rate held"

#: Rates [deg/s] that differ by less are the same but for rounding.
_SAME_RATE = 1e-12


@dataclass(frozen=True)
class Phase:
    """A stretch of constant body rate, or a ramp from one rate to the next.

    Attributes
    ----------
    label : str
        ``maneuver 2``, numbered as in the design, ``ramp to maneuver 2`` or ``rate held``.
    start, end : float
        [s] after the epoch.
    rates_deg_s : tuple of three floats
        About body x, y and z; of a ramp the mean.
    swept_deg : float
        Angle turned through [deg].
    """

    label: str
    start: float
    end: float
    rates_deg_s: tuple[float, float, float]
    swept_deg: float

    @property
    def duration(self) -> float:
        """[s]"""
        return self.end - self.start


def phases(
    design: ArrayLike, t_end: float, step: float, limits: SlewLimits | None = None
) -> tuple[Phase, ...]:
    """Phases of one design, shape (4 m,), up to `t_end`, as `schedule.flown` has them.

    Maneuvers shorter than a step may be left out. No rate is held where the run ends with the last
    maneuver.
    """
    flight = flown(design, t_end, step, limits)
    # not the flight's rates, which went through radians
    commanded = np.asarray(design, dtype=float).reshape(-1, VARIABLES_PER_MANEUVER)[:, :3]
    rates = np.degrees(flight.rates)
    reached = (np.abs(rates - commanded[flight.numbers]) < _SAME_RATE).all(axis=1)
    found = []
    for number in dict.fromkeys(flight.numbers.tolist()):
        own = np.flatnonzero(flight.numbers == number)
        steady = own[reached[own]][:1]
        ramp = own[own < steady[0]] if steady.size else own
        if ramp.size:
            lasting = np.diff(flight.times[ramp[0] : ramp[-1] + 2])
            found.append(_ramp(number, flight.times[ramp[0]], rates[ramp], lasting))
        if steady.size:
            start, end = float(flight.times[steady[0]]), float(flight.times[own[-1] + 1])
            stop = flight.over if end == t_end else end
            if stop > start:  # the last of the design may be over before its first step
                found.append(_steady(f"maneuver {number + 1}", start, stop, commanded[number]))
            if stop < end:
                found.append(_steady(HELD, stop, end, commanded[number]))
    return tuple(found)


def _steady(label: str, start: float, end: float, rate: np.ndarray) -> Phase:
    x, y, z = (float(component) for component in rate)
    return Phase(label, start, end, (x, y, z), float(np.linalg.norm(rate)) * (end - start))


def _ramp(number: int, start: float, rates: np.ndarray, lasting: np.ndarray) -> Phase:
    total = float(lasting.sum())
    x, y, z = (float(component) for component in lasting @ rates / total)
    swept = float(lasting @ np.linalg.norm(rates, axis=1))
    label = f"ramp to maneuver {number + 1}"
    return Phase(label, float(start), float(start) + total, (x, y, z), swept)
