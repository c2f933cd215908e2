"""Attitude history of a plan at given times, and its export as an STK attitude file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, get_args

import erfa
import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.times import as_utc
from mgeo_attitude.geometry.quaternion import interpolate_body_rates, interpolate_quaternions
from mgeo_attitude.maneuvers.motion import Phase
from mgeo_attitude.plan.plan import ManeuverPlan

#: Inertial frames by their names in CCSDS messages.
Frame = Literal["GCRF", "EME2000"]


@dataclass(frozen=True, eq=False)
class PhaseAttitudes:
    """Attitude history of one phase of a plan, sampled at equal intervals.

    Attributes
    ----------
    phase : Phase
    times : array, shape (k,)
        Times after the epoch of the scenario [s].
    q : array, shape (k, 4)
        Quaternions of the rotation from an inertial frame to the body, scalar part last, as in
        `geometry.quaternion`.
    rates : array, shape (k, 3)
        Body rates about the body axes [rad/s].
    """

    phase: Phase
    times: Floats
    q: Floats
    rates: Floats


def iterate_attitudes(
    plan: ManeuverPlan, spacing: float = 1.0, frame: Frame = "GCRF"
) -> Iterator[PhaseAttitudes]:
    """Yield the attitude history of each phase of a plan, including the slew back.

    Each phase is sampled at equal intervals of at most `spacing`, from its start to its end.

    Parameters
    ----------
    plan : ManeuverPlan
    spacing : float
        Largest time between attitudes [s].
    frame : {"GCRF", "EME2000"}
        Inertial frame of the quaternions.

    Yields
    ------
    PhaseAttitudes

    Raises
    ------
    ValueError
        If the spacing is not positive and finite, or if the frame is unknown.
    """
    if not 0.0 < spacing < math.inf:
        raise ValueError(f"spacing = {spacing!r}: expected a number of seconds above 0")
    if frame not in get_args(Frame):
        raise ValueError(f"frame = {frame!r}: expected {' or '.join(get_args(Frame))}")
    step = plan.scenario.step
    for phase in plan.phases:
        sample_times = np.linspace(phase.start, phase.end, math.ceil(phase.duration / spacing) + 1)
        first, last = plan.to_steps([phase.start, phase.end])
        times = step * np.arange(first, last + 1, dtype=float)
        matrices = plan.attitude[first : last + 1]
        if frame == "EME2000":
            matrices = matrices @ gcrf_to_eme2000().T
        yield PhaseAttitudes(
            phase,
            sample_times,
            interpolate_quaternions(times, matrices, sample_times),
            interpolate_body_rates(times, matrices, sample_times),
        )


def join_attitudes(plan: ManeuverPlan, spacing: float) -> tuple[Floats, Floats]:
    """Return the attitude history of all phases of a plan as arrays of times and quaternions.

    The instants at which two phases meet appear once. The signs of the quaternions are chosen so
    that their components are continuous.

    Parameters
    ----------
    plan : ManeuverPlan
    spacing : float
        Largest time between attitudes [s].

    Returns
    -------
    times : array, shape (k,)
        Times after the epoch of the scenario [s].
    q : array, shape (k, 4)
        Quaternions of the rotation from GCRF to the body, scalar part last.
    """
    phases = list(iterate_attitudes(plan, spacing))
    times = np.concatenate([phases[0].times[:1], *(phase.times[1:] for phase in phases)])
    q = np.concatenate([phases[0].q[:1], *(phase.q[1:] for phase in phases)])
    signs = np.where(np.einsum("ki,ki->k", q[:-1], q[1:]) < 0.0, -1.0, 1.0)
    return times, q * np.cumprod(np.append(1.0, signs))[:, None]


def format_violations(plan: ManeuverPlan) -> list[str]:
    """Format the violated constraints of a plan as comments for export files, one line each.

    The text is limited to ASCII characters.
    """
    lines = (f"VIOLATED CONSTRAINT: {each}" for each in plan.list_violations())
    return [line.encode("ascii", "replace").decode() for line in lines]


def gcrf_to_eme2000() -> Floats:
    """Return the rotation matrix from GCRF to EME2000, shape (3, 3).

    The rotation is the constant frame bias of 0.02 arc seconds (IAU 2006, computed by erfa; IERS
    Conventions 2010, section 5.4.4).

    Returns
    -------
    array, shape (3, 3)
    """
    return np.asarray(erfa.bp06(erfa.DJ00, 0.0)[0])


_MONTHS = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"]


def format_stk(plan: ManeuverPlan, *, spacing: float = 1.0) -> str:
    """Return the attitude history of a plan as the text of an STK attitude file.

    The history includes the slew back.

    The quaternions describe the rotation from ICRF to the body, with the scalar part last. Times
    are seconds after ScenarioEpoch, which is in UTC.

    Parameters
    ----------
    plan : ManeuverPlan
    spacing : float
        Largest time between attitudes [s].

    Returns
    -------
    str

    Raises
    ------
    ValueError
        If the spacing is not positive.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, format_stk
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> print(format_stk(plan).splitlines()[5])
    CoordinateAxes ICRF
    """
    times, q = join_attitudes(plan, spacing)
    epoch = as_utc(plan.scenario.epoch)
    clock = epoch.strftime("%H:%M:%S.%f")
    lines = [
        "stk.v.11.0",
        *(f"# {line}" for line in format_violations(plan)),
        "BEGIN Attitude",
        f"NumberOfAttitudePoints {len(times)}",
        f"ScenarioEpoch {epoch.day} {_MONTHS[epoch.month - 1]} {epoch.year} {clock}",
        "CentralBody Earth",
        "CoordinateAxes ICRF",
        "InterpolationOrder 1",
        "AttitudeTimeQuaternions",
    ]
    for time, row in zip(times, q, strict=True):
        lines.append(f"{time:.6f} " + " ".join(f"{part:.15f}" for part in row))
    return "\n".join([*lines, "END Attitude", ""])
