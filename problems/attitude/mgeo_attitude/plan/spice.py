"""Export of the planned attitude as a SPICE C-kernel (CK) with its spacecraft clock kernel (SCLK).

The C-kernel needs the extra ``spice`` (spiceypy). SPICE treats its frame J2000 as ICRF, without a
frame bias (NAIF, Frames Required Reading, "J2000"), so that it equals the frame of all tables of
this package.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from mgeo_attitude.environment.constants import DAY
from mgeo_attitude.environment.times import compute_julian_dates, format_time_stamps
from mgeo_attitude.plan.attitudes import format_violations, iterate_attitudes
from mgeo_attitude.plan.plan import ManeuverPlan

#: Default identifier, for a spacecraft to which NAIF has assigned none.
NAIF_ID = -999
_J2000 = 2451545.0
#: Ticks of the clock per second.
_TICKS = 1_000_000
#: Range of the clock [s].
_CLOCK_RANGE = 2**32


def build_ck(plan: ManeuverPlan, *, spacing: float = 1.0, naif_id: int = NAIF_ID) -> bytes:
    """Return the attitude history of a plan as a SPICE C-kernel of type 3.

    Each phase is a segment with attitudes and angular velocities. The structure is ``1000
    naif_id``, the base frame is J2000, and the clock is that of `format_sclk`.

    Parameters
    ----------
    plan : ManeuverPlan
    spacing : float
        Largest time between attitudes [s]. SPICE interpolates at constant rate.
    naif_id : int
        Identifier of the spacecraft, negative.

    Returns
    -------
    bytes

    Raises
    ------
    ValueError
        If the spacing is not positive or the identifier is not negative.
    ImportError
        If spiceypy is not installed.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, build_ck
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> build_ck(plan, naif_id=-123)[:7]  # doctest: +SKIP
    b'DAF/CK '
    """
    _check_naif_id(naif_id)
    try:
        import spiceypy as spice
    except ImportError as error:
        raise ImportError("a C-kernel needs the package spiceypy: pip install spiceypy") from error
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "attitude.bc"
        comments = format_violations(plan)
        handle = spice.ckopn(str(path), "planned attitude", sum(map(len, comments)) + 1000)
        if comments:
            spice.dafac(handle, comments)
        for part in iterate_attitudes(plan, spacing):
            ticks = np.rint(_TICKS * part.times)
            matrices = np.ascontiguousarray(Rotation.from_quat(part.q).inv().as_matrix())
            spice.ckw03(
                handle,
                ticks[0],
                ticks[-1],
                1000 * naif_id,
                "J2000",
                True,
                part.phase.label[:40],
                len(ticks),
                ticks,
                np.array([spice.m2q(matrix) for matrix in matrices]),
                np.einsum("kji,kj->ki", matrices, part.rates),
                1,
                ticks[:1],
            )
        spice.ckcls(handle)
        return path.read_bytes()


def format_sclk(plan: ManeuverPlan, *, naif_id: int = NAIF_ID) -> str:
    """Return the spacecraft clock kernel that SPICE needs to read the C-kernel of a plan.

    The clock counts microseconds from the epoch of the plan.

    Parameters
    ----------
    plan : ManeuverPlan
    naif_id : int
        Identifier of the spacecraft, negative.

    Returns
    -------
    str

    Raises
    ------
    ValueError
        If the identifier is not negative.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, format_sclk
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> format_sclk(plan, naif_id=-123).splitlines()[0]
    'KPL/SCLK'
    """
    _check_naif_id(naif_id)
    epoch_dates = compute_julian_dates(plan.scenario.epoch, [0.0])
    # A Julian date in one number resolves only 40 microseconds, so that whole days and the fraction
    # are converted separately.
    start = DAY * (epoch_dates.midnight - _J2000) + DAY * float(epoch_dates.tt[0])
    (epoch,) = format_time_stamps(plan.scenario.epoch, [0.0])
    number = -naif_id
    values = {
        "DATA_TYPE": "1",
        "01_TIME_SYSTEM": "2",
        "01_N_FIELDS": "2",
        "01_MODULI": f"{_CLOCK_RANGE} {_TICKS}",
        "01_OFFSETS": "0 0",
        "01_OUTPUT_DELIM": "1",
        "_PARTITION_START": "0.0",
        "_PARTITION_END": f"{_CLOCK_RANGE * _TICKS - 1:.16e}",
        "01_COEFFICIENTS": f"0.0 {start:.6f} 1.0",
    }
    lines = [
        "KPL/SCLK",
        "",
        f"Clock of the planned attitude: 1/0.0 is {epoch} UTC; microseconds.",
        "",
        "\\begindata",
        "",
        f"SCLK_KERNEL_ID = ( @{epoch[:10]} )",
        *(
            f"SCLK{'' if key[0] in '0_' else '_'}{key}_{number} = ( {value} )"
            for key, value in values.items()
        ),
        "",
        "\\begintext",
        "",
    ]
    return "\n".join(lines)


def _check_naif_id(naif_id: int) -> None:
    if naif_id >= 0:
        raise ValueError(f"naif_id = {naif_id!r}: expected an integer below 0")
