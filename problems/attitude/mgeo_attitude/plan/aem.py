"""The planned attitude as a CCSDS Attitude Ephemeris Message (CCSDS 504.0-B), in KVN.

Attitudes go from REF_FRAME_A to REF_FRAME_B with the scalar last. Version 1.0 (504.0-B-1, 2008)
says so with ATTITUDE_DIR = A2B and QUATERNION_TYPE = LAST; in 2.0 (504.0-B-2, 2024) it is always
so. Rates are the derivatives of the quaternion in 1.0, whose own rates are those of Euler angles,
and the angular velocity in body axes in 2.0. REF_FRAME_A is GCRF, the frame of all tables here:
EME2000 is not the same, its axes are 0.02 arc seconds off.

Each phase of constant rate is a segment of its own, across whose ends nobody may interpolate
(4.2.4.8.3), and begins at the instant at which the one before it ends.
"""

from __future__ import annotations

import math
from datetime import UTC, datetime
from typing import Literal, get_args

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.time_stamps import utc_texts
from mgeo_attitude.geometry.quaternion import (
    body_rates,
    quaternion_derivatives,
    sampled_quaternions,
)
from mgeo_attitude.maneuvers.phases import Phase
from mgeo_attitude.plan.plan import ManeuverPlan

Version = Literal["1.0", "2.0"]

#: Digits of a quaternion after the point: 16 in all (6.8.4.1).
_DIGITS = 15
#: A line has 254 characters at most (6.6.1); this leaves room for any keyword.
_LONGEST_VALUE = 200


def aem_text(
    plan: ManeuverPlan,
    *,
    object_name: str = "UNKNOWN",
    object_id: str = "UNKNOWN",
    originator: str = "UNKNOWN",
    created: datetime | None = None,
    version: Version = "1.0",
    spacing: float = 1.0,
) -> str:
    """The attitude of a plan from its start to its end, slew back included.

    Comments tell of the rate that is held for late flights, and name the constraints that the plan
    violates.

    Parameters
    ----------
    object_name, object_id, originator : str
        OBJECT_NAME, OBJECT_ID (international designator) and ORIGINATOR, in upper or lower case.
    created : datetime with UTC offset, optional
        CREATION_DATE; default: now.
    version : {"1.0", "2.0"}
    spacing : float
        Greatest time between attitudes [s]. Readers interpolate linearly: at 1 deg/s about all axes
        and the default 1 s they are wrong by less than 0.03 arc seconds in between.

    Raises
    ------
    ValueError
        For a text that the format does not allow, an unknown version, or a spacing not above zero.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, aem_text
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> print(aem_text(plan, object_name="MYSAT").splitlines()[0])
    CCSDS_AEM_VERS = 1.0
    """
    if version not in get_args(Version):
        raise ValueError(f"version = {version!r}: expected one of {', '.join(get_args(Version))}")
    if not 0.0 < spacing < math.inf:
        raise ValueError(f"spacing = {spacing!r}: expected a number of seconds above 0")
    texts = {"object_name": object_name, "object_id": object_id, "originator": originator}
    for key, value in texts.items():
        _check_text(key, value)
    names = [f"OBJECT_NAME = {object_name}", f"OBJECT_ID = {object_id}"]
    (creation_date,) = utc_texts(created or datetime.now(UTC), [0.0])
    lines = [
        f"CCSDS_AEM_VERS = {version}",
        _comment(f"planned attitude, scenario {plan.scenario.name}"),
        *(_comment(line) for line in plan.late()),
        *(_comment(f"VIOLATED CONSTRAINT: {violation}") for violation in plan.violations()),
        f"CREATION_DATE = {creation_date}",
        f"ORIGINATOR = {originator}",
    ]
    for phase in plan.phases:
        lines += ["", *_segment(plan, phase, names, version, spacing)]
    return "\n".join(lines) + "\n"


def _segment(
    plan: ManeuverPlan, phase: Phase, names: list[str], version: Version, spacing: float
) -> list[str]:
    at = np.linspace(phase.start, phase.end, math.ceil(phase.duration / spacing) + 1)
    epochs = utc_texts(plan.scenario.epoch, at)
    rates = " ".join(f"{rate:.6g}" for rate in phase.rates_deg_s)
    first_edition = version == "1.0"
    return [
        "META_START",
        f"COMMENT {phase.label}, body rates {rates} deg/s",
        *names,
        "CENTER_NAME = EARTH",
        "REF_FRAME_A = GCRF",
        "REF_FRAME_B = SC_BODY_1",
        *(["ATTITUDE_DIR = A2B"] if first_edition else []),
        "TIME_SYSTEM = UTC",
        f"START_TIME = {epochs[0]}",
        f"STOP_TIME = {epochs[-1]}",
        f"ATTITUDE_TYPE = QUATERNION/{'DERIVATIVE' if first_edition else 'ANGVEL'}",
        "QUATERNION_TYPE = LAST" if first_edition else "ANGVEL_FRAME = SC_BODY_1",
        "INTERPOLATION_METHOD = LINEAR",
        "INTERPOLATION_DEGREE = 1",
        "META_STOP",
        "DATA_START",
        *(
            f"{epoch} {' '.join(f'{part:.{_DIGITS}f}' for part in row)}"
            for epoch, row in zip(epochs, _rows(plan, phase, at, version), strict=True)
        ),
        "DATA_STOP",
    ]


def _rows(plan: ManeuverPlan, phase: Phase, at: Floats, version: Version) -> Floats:
    """Quaternions, and their derivatives [1/s] or angular velocities [deg/s]."""
    step = plan.scenario.step
    first, last = plan.steps([phase.start, phase.end])
    samples = slice(first, last + 1)
    times = step * np.arange(first, last + 1, dtype=float)
    q = sampled_quaternions(times, plan.attitude[samples], at)
    rates = body_rates(times, plan.attitude[samples], at)
    second = quaternion_derivatives(q, rates) if version == "1.0" else np.degrees(rates)
    rounded: Floats = np.hstack([q, second]).round(_DIGITS) + 0.0  # the format knows no -0
    return rounded


def _comment(text: str) -> str:
    """A line of printable text, cut where the format's lines end."""
    return f"COMMENT {text.encode('ascii', 'replace').decode()[:_LONGEST_VALUE]}"


def _check_text(key: str, value: str) -> None:
    one_case = value in (value.upper(), value.lower())
    printable = value.isascii() and value.isprintable() and value == value.strip() != ""
    if not (one_case and printable and len(value) <= _LONGEST_VALUE):
        raise ValueError(
            f"{key} = {value!r}: expected 1 to {_LONGEST_VALUE} printable ASCII characters, all "
            "upper or all lower case, without blanks at either end"
        )
