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
    """Compute the attitude at each filter step of a motion with piecewise constant body rate.

    Parameters
    ----------
    rates : array, shape (m, 3)
        Body rates of the intervals [rad/s].
    starts : array, shape (m,)
        First steps of the intervals.
    n_steps : int
        Number of filter steps.
    step : float
        Filter step [s].
    initial : array, shape (3, 3), optional
        Initial attitude. Default: body axes aligned with GCRS.

    Returns
    -------
    array, shape (n_steps + 1, 3, 3)
        GCRS-to-body matrices.
    """
    C = np.empty((n_steps + 1, 3, 3))
    C[0] = np.eye(3) if initial is None else initial
    ends = np.minimum(np.append(starts[1:], n_steps), n_steps)
    # Ramps and magnetorquers have an interval in each step, whose rotations are vectorized.
    step_rotations = (
        Rotation.from_rotvec(-step * rates).as_matrix() if len(rates) else np.empty((0, 3, 3))
    )
    intervals = zip(rates, step_rotations, starts.tolist(), ends.tolist(), strict=True)
    for omega, rotation, first, last in intervals:
        if last == first + 1:
            C[last] = rotation @ C[first]
        elif last > first:
            steps = np.arange(first, last + 1)
            rotations = Rotation.from_rotvec(-np.outer((steps - first) * step, omega))
            C[steps] = rotations.as_matrix() @ C[first]
    return C


class Body(Protocol):
    """Protocol of a satellite whose motion can be computed, such as a `FilterModel`."""

    @property
    def step(self) -> float:
        """Filter step [s]."""

    @property
    def slew_limits(self) -> RotationDynamics:
        """Slew limits or magnetorquer control, or None if the body rate changes instantaneously."""

    @property
    def initial_attitude(self) -> Floats:
        """GCRS-to-body matrix at the start, shape (3, 3)."""


@dataclass(frozen=True)
class Motion:
    """Nominal body rates and attitudes of a plan in n filter steps.

    The motion starts from the estimated initial attitude.

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
        """Compute the body rates and attitudes of a satellite that follows a design.

        Parameters
        ----------
        body : Body
            Satellite, such as a `FilterModel`.
        design : array_like, shape (4 m,)
            Rates and durations of m maneuvers; see `decode_designs`.
        n_steps : int
            Number of filter steps.

        Returns
        -------
        Motion
        """
        plan = build_rate_intervals(design, n_steps * body.step, body.step, body.slew_limits)
        starts = np.rint(plan.times[:-1] / body.step).astype(np.int64)
        interval = np.searchsorted(starts, np.arange(n_steps), side="right") - 1
        initial = body.initial_attitude
        matrices = compute_attitudes(plan.rates, starts, n_steps, body.step, initial)
        return cls(plan.rates[interval], matrices)


#: Label of the phase in which the rate of the last maneuver is held.
HOLD_LABEL = "constant-rate hold"
#: Prefix of the label of a ramp.
RAMP_PREFIX = "ramp to "
#: Suffix of the label of a phase that only serves runs in which the filter converges late.
AFTER_CONVERGENCE_SUFFIX = ", after nominal convergence"


@dataclass(frozen=True)
class Phase:
    """Phase of a plan for display: an interval of constant body rate, or a ramp between two rates.

    With magnetorquers, a ramp is the time in which the magnetorquers are on; free motion follows.

    Attributes
    ----------
    label : str
        ``maneuver 2``, numbered as in the design, ``ramp to maneuver 2`` or `HOLD_LABEL`. After the
        time of `split_phases`, the label ends with `AFTER_CONVERGENCE_SUFFIX`.
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
        """Duration of the phase [s]."""
        return self.end - self.start


def list_phases(
    design: ArrayLike,
    t_end: float,
    step: float,
    limits: RotationDynamics = None,
    names: Mapping[int, str] = MappingProxyType({}),
) -> tuple[Phase, ...]:
    """List the phases of a design in chronological order.

    The phases are the maneuvers, the ramps to their rates, and the constant-rate hold. A maneuver
    shorter than a step may be missing. There is no constant-rate hold if the run ends with the last
    maneuver.

    Parameters
    ----------
    design : array_like, shape (4 m,)
        Rates and durations of m maneuvers; see `decode_designs`.
    t_end : float
        End of the run [s].
    step : float
        Filter step [s].
    limits : SlewLimits or MagnetorquerDrive, optional
        See `build_schedule`.
    names : mapping of int to str
        Names of maneuvers, by number from 0, in place of ``maneuver N``.

    Returns
    -------
    tuple of Phase
    """
    intervals = build_rate_intervals(design, t_end, step, limits)
    # The commanded rates are those of the design, since a conversion to radians and back rounds.
    commanded = np.asarray(design, dtype=float).reshape(-1, VARIABLES_PER_MANEUVER)[:, :3]
    starts, ends = intervals.times[:-1], intervals.times[1:]
    result: list[Phase] = []

    def add(label: str, start: float, end: float, mean: Floats, angle: float) -> None:
        (x, y, z), (a, b, c) = mean.tolist(), rate.tolist()
        result.append(Phase(label, float(start), float(end), (x, y, z), (a, b, c), float(angle)))

    for number in dict.fromkeys(intervals.maneuver_numbers.tolist()):
        name = names.get(number, f"maneuver {number + 1}")
        selected, rate = intervals.maneuver_numbers == number, commanded[number]
        ramp, constant = selected & ~intervals.is_constant, selected & intervals.is_constant
        if ramp.any():
            begin, until = starts[ramp][0], ends[ramp][-1]
            add(
                f"{RAMP_PREFIX}{name}",
                begin,
                until,
                *_compute_mean_rate_and_angle(intervals, begin, until),
            )
        if constant.any():
            start, end = starts[constant][0], ends[constant][-1]
            stop = intervals.maneuver_end if end == t_end else end
            # The last maneuver may end before its first step.
            for label, begin, until in ((name, start, stop), (HOLD_LABEL, stop, end)):
                if begin < until and isinstance(limits, MagnetorquerDrive):
                    add(label, begin, until, *_compute_mean_rate_and_angle(intervals, begin, until))
                elif begin < until:
                    angle = float(np.linalg.norm(rate)) * (until - begin)
                    add(label, begin, until, rate, angle)
    return tuple(result)


def _compute_mean_rate_and_angle(
    intervals: RateIntervals, begin: float, until: float
) -> tuple[Floats, float]:
    """Return the mean rate [deg/s] and the accumulated rotation angle [deg] between two times."""
    edges = np.clip(intervals.times, begin, until)
    durations, rates = np.diff(edges), np.degrees(intervals.rates)
    return durations @ rates / (until - begin), float(durations @ np.linalg.norm(rates, axis=1))


def split_phases(plan_phases: tuple[Phase, ...], time: float) -> tuple[Phase, ...]:
    """Split the phases of a plan at a given time, and relabel the phases after this time.

    Only runs in which the filter converges late need the later phases. A ramp that contains the
    time is not split. Labels of later phases end with `AFTER_CONVERGENCE_SUFFIX`.

    Parameters
    ----------
    plan_phases : tuple of Phase
        Phases in chronological order.
    time : float
        Time after the epoch [s].

    Returns
    -------
    tuple of Phase
    """
    result: list[Phase] = []
    for phase in plan_phases:
        if phase.end <= time:
            result.append(phase)
            continue
        start = phase.start
        if phase.start < time and not phase.label.startswith(RAMP_PREFIX):
            before = replace(
                phase, end=time, rotation_deg=_compute_angle_share(phase, time - phase.start)
            )
            result.append(before)
            start = time
        label = f"{phase.label}{AFTER_CONVERGENCE_SUFFIX}"
        angle = _compute_angle_share(phase, phase.end - start)
        result.append(replace(phase, label=label, start=start, rotation_deg=angle))
    return tuple(result)


def _compute_angle_share(phase: Phase, duration: float) -> float:
    return phase.rotation_deg * (duration / phase.duration)
