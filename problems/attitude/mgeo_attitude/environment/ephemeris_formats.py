"""What files of ephemerides hold, and how it is read from either format.

Orbit ephemeris messages of the CCSDS (502.0-B, versions 1 to 3) in key-value notation (KVN), and
CSV tables whose header says what their columns are, with units.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import NamedTuple

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.frames import of_epoch
from mgeo_attitude.environment.times import seconds_after


@dataclass(frozen=True, eq=False)
class Segment:
    """Samples between which one may interpolate.

    `times` [s], increasing, count from the epoch that the reader was given; `position` [m] and
    `velocity` [m/s] are of shape (n, 3) in `frame`, whose axes may be those of one instant,
    `frame_epoch`, which counts as they do. It is good from `start` to `stop`, of which nothing is
    said if they are infinite; samples outside serve interpolation. What a file does not say is
    empty or None.
    """

    name: str
    frame: str
    times: Floats
    position: Floats
    velocity: Floats | None
    start: float = -math.inf
    stop: float = math.inf
    frame_epoch: float | None = None
    interpolation: str = ""
    degree: int | None = None


class Origin(NamedTuple):
    """The file that an orbit is from: its name, and the SHA-256 of what is in it."""

    file: str
    digest: str

    def of(self, name: str) -> str:
        """In words, of an object's orbit."""
        return ", ".join(filter(None, (self.file, name, f"SHA-256 {self.digest}")))


def numbers(line: int, words: Sequence[str]) -> list[float]:
    """Finite numbers of a line; anything else is a ValueError."""
    try:
        found = [float(word) for word in words]
    except ValueError:
        found = [math.nan]
    if not all(map(math.isfinite, found)):
        raise ValueError(f"line {line}: {' '.join(words)!r:.80}: expected finite numbers")
    return found


def in_order(times: Floats, stamps: Sequence[str]) -> Floats:
    """The times, if they are in order; else a ValueError with the stamps of the first two.

    The same twice is a jump, between before and after it.
    """
    steps = np.diff(times)
    wrong = steps < 0.0
    wrong[1:] |= (steps[1:] == 0.0) & (steps[:-1] == 0.0)
    for k in np.flatnonzero(wrong)[:1]:
        raise ValueError(
            f"time {stamps[k + 1]} after {stamps[k]}: expected times in order, the same at most "
            "twice"
        )
    return times


#: Metadata that are read, and the values that are understood; what may be missing has one for it.
_METADATA = {
    "OBJECT_NAME": r".+",
    "OBJECT_ID": r".+",
    "CENTER_NAME": r"EARTH",
    "REF_FRAME": r".+",
    "REF_FRAME_EPOCH": r".*",
    "TIME_SYSTEM": r".+",
    "USEABLE_START_TIME": r".*",
    "USEABLE_STOP_TIME": r".*",
    "INTERPOLATION": r"|HERMITE|LAGRANGE|LINEAR",
    "INTERPOLATION_DEGREE": r"|\d{1,3}",
}

#: Attributes of a segment, of metadata that are instants.
_INSTANTS = {
    "start": "USEABLE_START_TIME",
    "stop": "USEABLE_STOP_TIME",
    "frame_epoch": "REF_FRAME_EPOCH",
}

Lines = list[tuple[int, str]]  # each with its number


def read_oem(text: str, epoch: datetime) -> list[Segment]:
    """The segments of a message; times count from an epoch that has a UTC offset.

    Covariances, accelerations and comments are passed over.

    Raises
    ------
    ValueError
        Naming the line, the keyword or the time, and what was expected.
    """
    numbered = ((n, line.strip()) for n, line in enumerate(text.splitlines(), 1))
    lines = [(n, line) for n, line in numbered if line and not line.startswith("COMMENT")]
    starts = [i for i, (_, line) in enumerate(lines) if line == "META_START"]
    if not starts or not lines[0][1].startswith("CCSDS_OEM_VERS"):
        raise ValueError(
            "expected element sets (OMM, or two lines), or a message in KVN, with CCSDS_OEM_VERS "
            "first and META_START"
        )
    ends = [*starts[1:], len(lines)]
    return [_segment(lines[start:end], epoch) for start, end in zip(starts, ends, strict=True)]


def _segment(lines: Lines, epoch: datetime) -> Segment:
    texts = [line for _, line in lines]
    stop = texts.index("META_STOP") if "META_STOP" in texts else 0
    rows = lines[stop + 1 :]
    if "COVARIANCE_START" in texts:
        rows = lines[stop + 1 : texts.index("COVARIANCE_START")]
    if not stop or not rows:
        raise ValueError(f"line {lines[0][0]}: META_START: expected META_STOP and data after it")
    meta = _metadata(texts[1:stop])
    system, method = meta["TIME_SYSTEM"].upper(), meta["INTERPOLATION"].lower()
    stamps = [line.split()[0] for _, line in rows]
    times = in_order(seconds_after(epoch, stamps, system), stamps)
    states = 1e3 * np.array([_state(n, line.split()[1:]) for n, line in rows])  # from km
    limits = {
        name: float(seconds_after(epoch, [meta[key]], system)[0])
        for name, key in _INSTANTS.items()
        if meta[key]
    }
    if of_epoch(meta["REF_FRAME"]) and "frame_epoch" not in limits:
        raise ValueError(f"REF_FRAME = {meta['REF_FRAME']}: expected its REF_FRAME_EPOCH, too")
    degree = meta["INTERPOLATION_DEGREE"] or ("1" if method == "linear" else "")
    return Segment(
        name=f"{meta['OBJECT_NAME']} {meta['OBJECT_ID']}",
        frame=meta["REF_FRAME"],
        times=times,
        position=states[:, :3],
        velocity=states[:, 3:],
        interpolation="lagrange" if method == "linear" else method,
        degree=int(degree) if degree else None,
        **limits,
    )


def _metadata(lines: list[str]) -> dict[str, str]:
    pairs = (line.partition("=") for line in lines)
    given = {key.strip(): value.strip() for key, _, value in pairs}
    for key, pattern in _METADATA.items():
        value = given.setdefault(key, "")
        if not re.fullmatch(pattern, value, re.IGNORECASE):
            understood = " or ".join(pattern.strip("|").split("|")) if "." not in pattern else "one"
            expected = understood.replace(r"\d{1,3}", "an integer") or "none"
            raise ValueError(f"{key} = {value!r:.60}: expected {expected} (metadata)")
    return given


def _state(line: int, words: list[str]) -> list[float]:
    """Position and velocity [km], [km/s]; an acceleration may follow."""
    if len(words) not in (6, 9):
        raise ValueError(
            f"line {line}: {' '.join(words)!r:.80}: expected a time, then x, y, z [km] and "
            "x', y', z' [km/s]"
        )
    return numbers(line, words)[:6]


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
