"""A design as flown: rates and attitudes step by step, and phases for people."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.maneuvers.drives import CoilDrive
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER, Flown, Turning, flown


def attitudes(
    rates: Floats, starts: Ints, n_steps: int, step: float, initial: Floats | None = None
) -> Floats:
    """Attitude at every sample of one design: GCRS to body, shape (n_steps + 1, 3, 3).

    Parameters
    ----------
    rates : array, shape (m, 3)
        Body rates of the maneuvers [rad/s].
    starts : array, shape (m,)
        Their first steps.
    initial : array, shape (3, 3), optional
        Attitude at the start; default: body axes along those of GCRS.
    """
    C = np.empty((n_steps + 1, 3, 3))
    C[0] = np.eye(3) if initial is None else initial
    ends = np.minimum(np.append(starts[1:], n_steps), n_steps)
    # ramps, and coils, have a stretch in each step, which are turns to be made at once
    alone = Rotation.from_rotvec(-step * rates).as_matrix() if len(rates) else np.empty((0, 3, 3))
    for omega, turn, first, last in zip(rates, alone, starts.tolist(), ends.tolist(), strict=True):
        if last == first + 1:
            C[last] = turn @ C[first]
        elif last > first:
            steps = np.arange(first, last + 1)
            turns = Rotation.from_rotvec(-np.outer((steps - first) * step, omega))
            C[steps] = turns.as_matrix() @ C[first]
    return C


class Body(Protocol):
    """What is turned; a `FilterModel` tells it."""

    @property
    def step(self) -> float:
        """Step of the filter [s]."""

    @property
    def slew_limits(self) -> Turning:
        """What turns it from one rate to the next, if not at once."""

    @property
    def initial_attitude(self) -> Floats:
        """GCRS to body at the start, shape (3, 3)."""


@dataclass(frozen=True)
class Motion:
    """A plan on n steps, from the attitude at the start that is believed.

    Attributes
    ----------
    rates : array, shape (n, 3)
        Body rate in each step [rad/s].
    attitude : array, shape (n + 1, 3, 3)
        GCRS to body.
    """

    rates: Floats
    attitude: Floats

    @classmethod
    def of(cls, body: Body, design: ArrayLike, n_steps: int) -> Motion:
        """Of a design, shape (4 m,), and what flies it."""
        plan = flown(design, n_steps * body.step, body.step, body.slew_limits)
        starts = np.rint(plan.times[:-1] / body.step).astype(np.int64)
        stretch = np.searchsorted(starts, np.arange(n_steps), side="right") - 1
        initial = body.initial_attitude
        flown_attitudes = attitudes(plan.rates, starts, n_steps, body.step, initial)
        return cls(plan.rates[stretch], flown_attitudes)


#: Label of the time for which the last rate is held.
HELD = "rate held"
#: With what the label of a ramp begins.
RAMP = "ramp to "
#: What follows the label of a phase that is flown only for those flights that converge late.
LATE = ", for late flights"


@dataclass(frozen=True)
class Phase:
    """A stretch of constant body rate, or a ramp from one rate to the next.

    With coils a ramp is the time for which they are on, and what follows it is free motion.

    Attributes
    ----------
    label : str
        ``maneuver 2``, numbered as in the design, ``ramp to maneuver 2`` or ``rate held``; of what
        is `divided` from a phase with `LATE` after it.
    start, end : float
        [s] after the epoch.
    rates_deg_s : tuple of three floats
        About body x, y and z; of a ramp, or of free motion, the mean.
    commanded_deg_s : tuple of three floats
        Those of its maneuver, which a ramp leads to.
    swept_deg : float
        Angle turned through [deg].
    """

    label: str
    start: float
    end: float
    rates_deg_s: tuple[float, float, float]
    commanded_deg_s: tuple[float, float, float]
    swept_deg: float

    @property
    def duration(self) -> float:
        """[s]"""
        return self.end - self.start


def phases(
    design: ArrayLike,
    t_end: float,
    step: float,
    limits: Turning = None,
    names: Mapping[int, str] = MappingProxyType({}),
) -> tuple[Phase, ...]:
    """Phases of one design, shape (4 m,), up to `t_end`, as `schedule.flown` has them.

    Maneuvers shorter than a step may be left out. No rate is held where the run ends with the last
    maneuver. By their numbers, from 0, `names` says what maneuvers are called otherwise.
    """
    flight = flown(design, t_end, step, limits)
    # not the flight's rates, which went through radians
    commanded = np.asarray(design, dtype=float).reshape(-1, VARIABLES_PER_MANEUVER)[:, :3]
    starts, ends = flight.times[:-1], flight.times[1:]
    found: list[Phase] = []

    def add(label: str, start: float, end: float, mean: Floats, swept: float) -> None:
        (x, y, z), (a, b, c) = mean.tolist(), rate.tolist()
        found.append(Phase(label, float(start), float(end), (x, y, z), (a, b, c), float(swept)))

    for number in dict.fromkeys(flight.numbers.tolist()):
        name = names.get(number, f"maneuver {number + 1}")
        own, rate = flight.numbers == number, commanded[number]
        ramp, held = own & ~flight.steady, own & flight.steady
        if ramp.any():
            begin, until = starts[ramp][0], ends[ramp][-1]
            add(f"{RAMP}{name}", begin, until, *_turned(flight, begin, until))
        if held.any():
            start, end = starts[held][0], ends[held][-1]
            stop = flight.over if end == t_end else end
            # the last of the design may be over before its first step
            for label, begin, until in ((name, start, stop), (HELD, stop, end)):
                if begin < until and isinstance(limits, CoilDrive):
                    add(label, begin, until, *_turned(flight, begin, until))
                elif begin < until:
                    swept = float(np.linalg.norm(rate)) * (until - begin)
                    add(label, begin, until, rate, swept)
    return tuple(found)


def _turned(flight: Flown, begin: float, until: float) -> tuple[Floats, float]:
    """Mean rate [deg/s], and angle turned through [deg], of what is flown between two times."""
    edges = np.clip(flight.times, begin, until)
    lasting, rates = np.diff(edges), np.degrees(flight.rates)
    return lasting @ rates / (until - begin), float(lasting @ np.linalg.norm(rates, axis=1))


def divided(flown: tuple[Phase, ...], time: float) -> tuple[Phase, ...]:
    """With an edge at a time [s] of a phase of constant rate, after which phases are `LATE`."""
    found: list[Phase] = []
    for phase in flown:
        if phase.end <= time:
            found.append(phase)
            continue
        since = phase.start
        if phase.start < time and not phase.label.startswith(RAMP):
            before = replace(phase, end=time, swept_deg=_swept(phase, time - phase.start))
            found.append(before)
            since = time
        late, swept = f"{phase.label}{LATE}", _swept(phase, phase.end - since)
        found.append(replace(phase, label=late, start=since, swept_deg=swept))
    return tuple(found)


def _swept(phase: Phase, duration: float) -> float:
    return phase.swept_deg * (duration / phase.duration)
