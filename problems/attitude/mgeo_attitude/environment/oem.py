"""Orbit ephemeris messages of the CCSDS (502.0-B, versions 1 to 3) in key-value notation (KVN)."""

from __future__ import annotations

import re
from datetime import datetime

import numpy as np

from mgeo_attitude.environment.frames import of_epoch
from mgeo_attitude.environment.segment import Segment, in_order, numbers
from mgeo_attitude.environment.time_stamps import seconds_after

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
