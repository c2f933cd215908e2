"""An orbit in a file of another tool: what a run needs of it becomes part of the scenario."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import ClassVar

import numpy as np

from mgeo_attitude.environment.ephemeris import (
    DEFAULT_DEGREE,
    MOST_DEGREE,
    SAME_INSTANT,
    EphemerisOrbit,
    points,
)
from mgeo_attitude.environment.frames import frame_name, to_gcrs
from mgeo_attitude.environment.oem import read_oem
from mgeo_attitude.environment.position_table import read_position_table
from mgeo_attitude.environment.segment import Segment
from mgeo_attitude.environment.time_frames import as_utc, instants
from mgeo_attitude.fields import InvalidValue, Validated, expect, quantity

_MOST_BYTES = 2**26


@dataclass(frozen=True, kw_only=True)
class EphemerisFile(Validated):
    """A CCSDS orbit ephemeris message (OEM in KVN), or a table of positions (``.csv``).

    A scenario keeps the samples that `for_run` gives, and not the file, which may change.

    Raises
    ------
    InvalidValue, InvalidType
        For a table without a frame, a message with one (it names its own), or an unknown one.
    """

    propagator: ClassVar[str] = "ephemeris-file"

    file: str = quantity(doc="an OEM, or a table .csv, in the scenario file's folder")
    frame: str = quantity("", doc="frame of a table: GCRF, EME2000, TEME or ITRF")
    interpolation: str | None = quantity(
        None,
        choices=("hermite", "lagrange"),
        doc="through velocities too, or positions only, if not as the file says",
    )
    degree: int | None = quantity(
        None, low=1, high=MOST_DEGREE, doc="degree of the polynomials, if not as the file says"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self._is_table:
            try:
                frame_name(self.frame)
            except ValueError as error:
                raise InvalidValue("frame", self.frame, f"{error}") from None
        else:
            expect(not self.frame, "frame", self.frame, "none: only a table .csv needs one")

    def for_run(self, epoch: datetime, duration: float) -> EphemerisOrbit:
        """The samples for a run of `duration` [s] from an epoch with a UTC offset.

        Those before and after the run that interpolation takes are among them.

        Raises
        ------
        OSError, InvalidValue
            Naming the file and what is wrong in it or missing, such as a part of the run.
        """
        path = Path(self.file)
        expect(path.is_file(), "file", self.file, "a file, and there is none")
        size = path.stat().st_size
        expect(size <= _MOST_BYTES, "file", self.file, f"at most {_MOST_BYTES} bytes, not {size}")
        content = path.read_bytes()
        try:
            segment = _covering(self._segments(content.decode("utf-8-sig"), epoch), epoch, duration)
            parts = (path.name, segment.name, f"SHA-256 {hashlib.sha256(content).hexdigest()}")
            return self._orbit(segment, epoch, duration, ", ".join(filter(None, parts)))
        except ValueError as error:
            raise InvalidValue("file", self.file, f"{error}") from None

    @property
    def _is_table(self) -> bool:
        return self.file.lower().endswith(".csv")

    def _segments(self, text: str, epoch: datetime) -> list[Segment]:
        if self._is_table:
            return [read_position_table(text, epoch, self.frame)]
        return read_oem(text, epoch)

    def _orbit(
        self, segment: Segment, epoch: datetime, duration: float, source: str
    ) -> EphemerisOrbit:
        method = self.interpolation or segment.interpolation
        velocity = None if method == "lagrange" else segment.velocity
        if method == "hermite" and velocity is None:
            raise ValueError("interpolation = 'hermite': expected a table with velocities")
        degree = self.degree or segment.degree or DEFAULT_DEGREE
        margin = points(degree, velocity is not None)
        first, last = np.searchsorted(segment.times, [SAME_INSTANT, duration - SAME_INSTANT])
        kept = slice(max(0, first - 1 - margin), last + 1 + margin)
        times = segment.times[kept]
        position, velocity = to_gcrs(
            frame_name(segment.frame),
            instants(epoch, times),
            segment.position[kept],
            None if velocity is None else velocity[kept],
        )
        return EphemerisOrbit(
            source=source,
            epoch=epoch,
            degree=degree,
            times=times.tolist(),
            position=position.tolist(),
            velocity=() if velocity is None else velocity.tolist(),
        )


def _covering(segments: Sequence[Segment], epoch: datetime, duration: float) -> Segment:
    """The one that reaches from start to end of a run; across their ends nobody interpolates."""
    spans = [(max(s.times[0], s.start), min(s.times[-1], s.stop)) for s in segments]
    fitting = [
        segment
        for segment, (start, stop) in zip(segments, spans, strict=True)
        if start <= SAME_INSTANT and duration <= stop + SAME_INSTANT
    ]
    if not fitting:
        found = " and ".join(f"from {_utc(epoch, a)} to {_utc(epoch, b)}" for a, b in spans[:3])
        more = f" and {len(spans) - 3} more" if len(spans) > 3 else ""
        raise ValueError(
            f"expected samples for the whole run, from {_utc(epoch, 0.0)} to "
            f"{_utc(epoch, duration)}, in one segment; found {found}{more}"
        )
    if others := {segment.name for segment in fitting} - {fitting[0].name}:
        raise ValueError(f"expected one object, not {fitting[0].name} and {others.pop()}")
    return fitting[0]


def _utc(epoch: datetime, seconds: float) -> str:
    instant = as_utc(epoch) + timedelta(seconds=float(seconds))
    return instant.isoformat(timespec="milliseconds").replace("+00:00", "Z")
