"""Motion along a design: rates and attitudes at every step, and phases for display."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.maneuvers.actuation import MagnetorquerDrive
from mgeo_attitude.maneuvers.schedule import (
    VARIABLES_PER_MANEUVER,
    RateIntervals,
    RotationDynamics,
    build_rate_intervals,
)


def compute_attitudes(
    rates: Floats, starts: Ints, n_steps: int, step: float, initial: Floats | None = None
) -> Floats:
    """Return the GCRS-to-body matrix of one design at every sample, shape (n_steps + 1, 3, 3).

    Parameters
    ----------
    rates : array, shape (m, 3)
        Body rates of the maneuvers [rad/s].
    starts : array, shape (m,)
        First steps of the maneuvers.
    n_steps : int
    step : float
        Filter step [s].
    initial : array, shape (3, 3), optional
        Initial attitude. Default: body axes aligned with GCRS.
    """
    C = np.empty((n_steps + 1, 3, 3))
    C[0] = np.eye(3) if initial is None else initial
    ends = np.minimum(np.append(starts[1:], n_steps), n_steps)
    # Ramps and magnetorquers have an interval in each step, whose rotations are vectorized.
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
    """Satellite whose attitude moves; implemented by `FilterModel`."""

    @property
    def step(self) -> float:
        """Filter step [s]."""

    @property
    def slew_limits(self) -> RotationDynamics:
        """Limits on rate changes, or magnetorquer control; None for instantaneous changes."""

    @property
    def initial_attitude(self) -> Floats:
        """GCRS-to-body matrix at the start, shape (3, 3)."""


@dataclass(frozen=True)
class Motion:
    """Nominal motion of a plan over n steps, from the estimated initial attitude.

    Attributes
    ----------
    rates : array, shape (n, 3)
        Body rate in each step [rad/s].
    attitude : array, shape (n + 1, 3, 3)
        GCRS-to-body matrices.
    """

    rates: Floats
    attitude: Floats

    @classmethod
    def from_design(cls, body: Body, design: ArrayLike, n_steps: int) -> Motion:
        """Compute the motion of a body along a design, shape (4 m,)."""
        plan = build_rate_intervals(design, n_steps * body.step, body.step, body.slew_limits)
        starts = np.rint(plan.times[:-1] / body.step).astype(np.int64)
        stretch = np.searchsorted(starts, np.arange(n_steps), side="right") - 1
        initial = body.initial_attitude
        matrices = compute_attitudes(plan.rates, starts, n_steps, body.step, initial)
        return cls(plan.rates[stretch], matrices)


#: Label of the phase in which the last rate is held.
HOLD_LABEL = "constant-rate hold"
#: Prefix of the label of a ramp.
RAMP_PREFIX = "ramp to "
#: Suffix of the label of a phase that only serves runs that converge late.
LATE_CONVERGENCE_SUFFIX = ", for late convergence"


@dataclass(frozen=True)
class Phase:
    """Interval of constant body rate, or a ramp between two rates.

    With magnetorquers, a ramp is the time in which the coils are on; free motion follows.

    Attributes
    ----------
    label : str
        ``maneuver 2``, numbered as in the design, ``ramp to maneuver 2`` or ``rate held``. After
        the time of `split_phases`, the label ends with `LATE_CONVERGENCE_SUFFIX`.
    start, end : float
        Start and end [s] after the epoch.
    rates_deg_s : tuple of three floats
        Body rate about x, y and z [deg/s]; the mean of a ramp or of free motion.
    commanded_deg_s : tuple of three floats
        Rate of the maneuver [deg/s], to which a ramp leads.
    rotation_deg : float
        Accumulated rotation angle [deg].
    """

    label: str
    start: float
    end: float
    rates_deg_s: tuple[float, float, float]
    commanded_deg_s: tuple[float, float, float]
    rotation_deg: float

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return self.end - self.start


def list_phases(
    design: ArrayLike,
    t_end: float,
    step: float,
    limits: RotationDynamics = None,
    names: Mapping[int, str] = MappingProxyType({}),
) -> tuple[Phase, ...]:
    """Return the phases of one design until `t_end`.

    A maneuver shorter than a step may be missing. There is no phase of a held rate if the run ends
    with the last maneuver.

    Parameters
    ----------
    design : array_like, shape (4 m,)
    t_end : float
        End of the run [s].
    step : float
        Filter step [s].
    limits : SlewLimits or MagnetorquerDrive, optional
        See `schedule`.
    names : mapping of int to str
        Names of maneuvers, by number from 0, in place of ``maneuver N``.
    """
    flight = build_rate_intervals(design, t_end, step, limits)
    # The rates come from the design, because a conversion to radians and back would round them.
    commanded = np.asarray(design, dtype=float).reshape(-1, VARIABLES_PER_MANEUVER)[:, :3]
    starts, ends = flight.times[:-1], flight.times[1:]
    result: list[Phase] = []

    def add(label: str, start: float, end: float, mean: Floats, swept: float) -> None:
        (x, y, z), (a, b, c) = mean.tolist(), rate.tolist()
        result.append(Phase(label, float(start), float(end), (x, y, z), (a, b, c), float(swept)))

    for number in dict.fromkeys(flight.maneuver_numbers.tolist()):
        name = names.get(number, f"maneuver {number + 1}")
        own, rate = flight.maneuver_numbers == number, commanded[number]
        ramp, steady = own & ~flight.is_constant, own & flight.is_constant
        if ramp.any():
            begin, until = starts[ramp][0], ends[ramp][-1]
            add(
                f"{RAMP_PREFIX}{name}",
                begin,
                until,
                *_compute_mean_rate_and_angle(flight, begin, until),
            )
        if steady.any():
            start, end = starts[steady][0], ends[steady][-1]
            stop = flight.maneuver_end if end == t_end else end
            # The last maneuver may end before its first step.
            for label, begin, until in ((name, start, stop), (HOLD_LABEL, stop, end)):
                if begin < until and isinstance(limits, MagnetorquerDrive):
                    add(label, begin, until, *_compute_mean_rate_and_angle(flight, begin, until))
                elif begin < until:
                    swept = float(np.linalg.norm(rate)) * (until - begin)
                    add(label, begin, until, rate, swept)
    return tuple(result)


def _compute_mean_rate_and_angle(
    intervals: RateIntervals, begin: float, until: float
) -> tuple[Floats, float]:
    """Return the mean rate [deg/s] and the accumulated rotation angle [deg] between two times."""
    edges = np.clip(intervals.times, begin, until)
    durations, rates = np.diff(edges), np.degrees(intervals.rates)
    return durations @ rates / (until - begin), float(durations @ np.linalg.norm(rates, axis=1))


def split_phases(plan_phases: tuple[Phase, ...], time: float) -> tuple[Phase, ...]:
    """Split the phase of constant rate at a time [s], and mark all later phases with `LATE_CONVERGENCE_SUFFIX`."""
    result: list[Phase] = []
    for phase in plan_phases:
        if phase.end <= time:
            result.append(phase)
            continue
        since = phase.start
        if phase.start < time and not phase.label.startswith(RAMP_PREFIX):
            before = replace(
                phase, end=time, rotation_deg=_compute_angle_share(phase, time - phase.start)
            )
            result.append(before)
            since = time
        late, swept = (
            f"{phase.label}{LATE_CONVERGENCE_SUFFIX}",
            _compute_angle_share(phase, phase.end - since),
        )
        result.append(replace(phase, label=late, start=since, rotation_deg=swept))
    return tuple(result)


def _compute_angle_share(phase: Phase, duration: float) -> float:
    return phase.rotation_deg * (duration / phase.duration)
