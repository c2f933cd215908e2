"""Positions in a table: CSV whose header says what its columns are, with units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from datetime import datetime

import numpy as np

from mgeo_attitude.environment.segment import Segment, in_order, numbers
from mgeo_attitude.environment.time_stamps import seconds_after

Columns = tuple[str, ...]

_TIMES: dict[Columns, float] = {("time_utc",): 1.0, ("time_s",): 1.0}
#: What makes m or m/s of the columns.
_POSITIONS: dict[Columns, float] = {("x_m", "y_m", "z_m"): 1.0, ("x_km", "y_km", "z_km"): 1e3}
_VELOCITIES: dict[Columns, float] = {
    ("vx_m_s", "vy_m_s", "vz_m_s"): 1.0,
    ("vx_km_s", "vy_km_s", "vz_km_s"): 1e3,
}


def read_position_table(text: str, epoch: datetime, frame: str) -> Segment:
    """The samples of a table, in a reference frame that the table does not name.

    ``time_s`` are SI seconds after the epoch, which has a UTC offset; ``time_utc`` are texts in ISO
    8601. Empty lines and those that begin with # are passed over.

    Raises
    ------
    ValueError
        Naming the line, the columns or the time, and what was expected.
    """
    numbered = ((n, line.strip()) for n, line in enumerate(text.splitlines(), 1))
    lines = [(n, line.split(",")) for n, line in numbered if line and not line.startswith("#")]
    if len(lines) < 2:
        raise ValueError("expected a header, which names the columns, and rows below it")
    header = [name.strip() for name in lines[0][1]]
    time, place, motion = (_found(header, known) for known in (_TIMES, _POSITIONS, _VELOCITIES))
    if sorted(header) != sorted(time + place + motion) or not (time and place):
        raise ValueError(
            f"columns {','.join(header)!r:.120}: expected {_listed(_TIMES)}, with "
            f"{_listed(_POSITIONS)}, and perhaps {_listed(_VELOCITIES)}"
        )
    for n, cells in lines:
        if len(cells) != len(header):
            raise ValueError(f"line {n}: {len(cells)} cells: expected {len(header)}, as its header")
    rows = [(n, dict(zip(header, cells, strict=True))) for n, cells in lines[1:]]
    stamps = [row[time[0]].strip() for _, row in rows]
    seconds = [numbers(n, [row[time[0]]])[0] for n, row in rows] if time == ("time_s",) else None
    times = seconds_after(epoch, stamps) if seconds is None else np.array(seconds)
    states = np.array([numbers(n, [row[x] for x in place + motion]) for n, row in rows])
    return Segment(
        name="",
        frame=frame,
        times=in_order(times, stamps),
        position=_POSITIONS[place] * states[:, :3],
        velocity=_VELOCITIES[motion] * states[:, 3:] if motion else None,
    )


def _found(header: list[str], known: Iterable[Columns]) -> Columns:
    """Those that the header has, the first of them if it has more."""
    return next((columns for columns in known if set(columns) <= set(header)), ())


def _listed(known: Mapping[Columns, float]) -> str:
    return " or ".join(map(",".join, known))
