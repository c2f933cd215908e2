"""Export of the planned attitude as a CCSDS Attitude Ephemeris Message (AEM, CCSDS 504.0-B) in KVN.

Attitudes are rotations from REF_FRAME_A to REF_FRAME_B, as quaternions with the scalar part last.
Version 1.0 (504.0-B-1, 2008) declares this by ATTITUDE_DIR = A2B and QUATERNION_TYPE = LAST;
version 2.0 (504.0-B-2, 2024) implies it. Version 1.0 defines rates only for Euler angles, so that
rates are written as quaternion derivatives; in version 2.0 they are angular velocities in body
axes. REF_FRAME_A is GCRF, the frame of all tables of this package, or EME2000, whose axes differ by
0.02 arc seconds.

Each phase of the plan is a segment, because readers must not interpolate across the ends of a
segment (4.2.4.8.3). A segment starts at the instant at which the previous segment ends.
"""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Literal, get_args

import numpy as np

from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.geometry.quaternion import quaternion_derivatives
from mgeo_attitude.plan.attitudes import Frame, PhaseAttitudes, iterate_attitudes
from mgeo_attitude.plan.plan import ManeuverPlan

Version = Literal["1.0", "2.0"]
Rates = Literal["given", "none"]

#: Decimals of a quaternion; the standard allows 16 digits (6.8.4.1).
_DIGITS = 15
#: Largest length of a value: lines have at most 254 characters (6.6.1), keyword included.
_LONGEST_VALUE = 200


def format_aem(
    plan: ManeuverPlan,
    *,
    object_name: str = "UNKNOWN",
    object_id: str = "UNKNOWN",
    originator: str = "UNKNOWN",
    creation_time: datetime | None = None,
    version: Version = "1.0",
    spacing: float = 1.0,
    rates: Rates = "given",
    frame: Frame = "GCRF",
) -> str:
    """Return the attitude history of a plan as a CCSDS Attitude Ephemeris Message (AEM).

    The history includes the slew back.

    Comments of the message describe a constant-rate hold beyond the nominal convergence, if there
    is one, and list violated constraints.

    Parameters
    ----------
    plan : ManeuverPlan
    object_name, object_id, originator : str
        OBJECT_NAME, OBJECT_ID (international designator) and ORIGINATOR, in upper or lower case.
    creation_time : datetime with UTC offset, optional
        CREATION_DATE; default: now.
    version : {"1.0", "2.0"}
        CCSDS_AEM_VERS.
    spacing : float
        Largest time between attitudes [s]. Readers interpolate linearly, with an error below 0.03
        arc seconds at the default spacing and 1 deg/s about all axes.
    rates : {"given", "none"}
        Whether to write rates. Many readers accept only quaternions without rates.
    frame : {"GCRF", "EME2000"}
        REF_FRAME_A.

    Returns
    -------
    str

    Raises
    ------
    ValueError
        If a text is not allowed in the format, if the version, frame or kind of rates is unknown,
        or if the spacing is not positive.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, format_aem
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> print(format_aem(plan, object_name="MYSAT").splitlines()[0])
    CCSDS_AEM_VERS = 1.0
    """
    for key, value, choices in (("version", version, Version), ("rates", rates, Rates)):
        if value not in get_args(choices):
            raise ValueError(f"{key} = {value!r}: expected one of {', '.join(get_args(choices))}")
    texts = {"object_name": object_name, "object_id": object_id, "originator": originator}
    for key, text in texts.items():
        _check_text(key, text)
    names = [f"OBJECT_NAME = {object_name}", f"OBJECT_ID = {object_id}"]
    (creation_date,) = format_time_stamps(creation_time or datetime.now(UTC), [0.0])
    lines = [
        f"CCSDS_AEM_VERS = {version}",
        _format_comment(f"planned attitude, scenario {plan.scenario.name}"),
        *(_format_comment(line) for line in plan.describe_hold()),
        *(
            _format_comment(f"VIOLATED CONSTRAINT: {violation}")
            for violation in plan.list_violations()
        ),
        f"CREATION_DATE = {creation_date}",
        f"ORIGINATOR = {originator}",
    ]
    for part in iterate_attitudes(plan, spacing, frame):
        lines += ["", *_format_segment(plan, part, names, version, rates, frame)]
    return "\n".join(lines) + "\n"


def _format_segment(
    plan: ManeuverPlan,
    part: PhaseAttitudes,
    names: list[str],
    version: Version,
    rates: Rates,
    frame: Frame,
) -> list[str]:
    epochs = format_time_stamps(plan.scenario.epoch, part.times)
    body_rates = " ".join(f"{rate:.6g}" for rate in part.phase.rates_deg_s)
    first_edition = version == "1.0"
    kind, columns, lines = "QUATERNION", [part.q], ["QUATERNION_TYPE = LAST"]
    if rates == "given":
        kind += "/DERIVATIVE" if first_edition else "/ANGVEL"
        columns.append(
            quaternion_derivatives(part.q, part.rates) if first_edition else np.degrees(part.rates)
        )
    if not first_edition:
        lines = ["ANGVEL_FRAME = SC_BODY_1"] if rates == "given" else []
    rows = np.hstack(columns).round(_DIGITS) + 0.0  # AEM does not allow -0.
    return [
        "META_START",
        f"COMMENT {part.phase.label}, body rates {body_rates} deg/s",
        *names,
        "CENTER_NAME = EARTH",
        f"REF_FRAME_A = {frame}",
        "REF_FRAME_B = SC_BODY_1",
        *(["ATTITUDE_DIR = A2B"] if first_edition else []),
        "TIME_SYSTEM = UTC",
        f"START_TIME = {epochs[0]}",
        f"STOP_TIME = {epochs[-1]}",
        f"ATTITUDE_TYPE = {kind}",
        *lines,
        "INTERPOLATION_METHOD = LINEAR",
        "INTERPOLATION_DEGREE = 1",
        "META_STOP",
        "DATA_START",
        *(
            f"{epoch} {' '.join(f'{value:.{_DIGITS}f}' for value in row)}"
            for epoch, row in zip(epochs, rows, strict=True)
        ),
        "DATA_STOP",
    ]


def _format_comment(text: str) -> str:
    return f"COMMENT {text.encode('ascii', 'replace').decode()[:_LONGEST_VALUE]}"


def _check_text(key: str, value: str) -> None:
    one_case = value in (value.upper(), value.lower())
    printable = value.isascii() and value.isprintable() and value == value.strip() != ""
    if not (one_case and printable and len(value) <= _LONGEST_VALUE):
        raise ValueError(
            f"{key} = {value!r}: expected 1 to {_LONGEST_VALUE} printable ASCII characters, all "
            "upper or all lower case, without leading or trailing blanks"
        )
