"""An orbit in a file of another tool: what a run needs of it becomes part of the scenario."""

from __future__ import annotations

import gzip
import hashlib
import zlib
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import ClassVar

from mgeo_attitude.environment.element_file import element_set, is_element_file
from mgeo_attitude.environment.ephemeris import MOST_DEGREE, EphemerisOrbit
from mgeo_attitude.environment.ephemeris_file import Run, ephemeris_of, one_object
from mgeo_attitude.environment.frames import frame_name
from mgeo_attitude.environment.mean_elements import MeanElements
from mgeo_attitude.environment.oem import read_oem
from mgeo_attitude.environment.position_table import read_position_table
from mgeo_attitude.environment.segment import Origin
from mgeo_attitude.environment.tle import TLEOrbit
from mgeo_attitude.fields import InvalidValue, Validated, expect, quantity

_MOST_BYTES = 2**26


@dataclass(frozen=True, kw_only=True)
class OrbitFile(Validated):
    """Element sets (OMM, or two lines), an orbit ephemeris message (OEM in KVN), or a table of
    positions (``.csv``); each also compressed (``.gz``).

    What it is, it says itself. A scenario keeps the elements or samples that `for_run` gives, and
    not the file, which may change.

    Raises
    ------
    InvalidValue, InvalidType
        For a value out of its range.

    Examples
    --------
    >>> from mgeo_attitude.scenario import OrbitFile
    >>> OrbitFile(file="stations.omm", object="25544").object
    '25544'
    """

    propagator: ClassVar[str] = "file"

    file: str = quantity(doc="element sets or an ephemeris, in the scenario file's folder")
    object: str = quantity("", doc="which of several objects: name, designator or catalog number")
    frame: str = quantity("", doc="frame of a table: GCRF, EME2000, TEME, TOD, MOD or ITRF")
    interpolation: str | None = quantity(
        None,
        choices=("hermite", "lagrange"),
        doc="through velocities too, or positions only, if not as the file says",
    )
    degree: int | None = quantity(
        None, low=1, high=MOST_DEGREE, doc="degree of the polynomials, if not as the file says"
    )

    def for_run(self, epoch: datetime, duration: float) -> EphemerisOrbit | TLEOrbit | MeanElements:
        """What a run of `duration` [s] from an epoch with a UTC offset needs.

        Of an ephemeris, the samples before and after the run that interpolation takes are in it.

        Raises
        ------
        OSError, InvalidValue
            Naming the file and what is wrong in it or missing, such as a part of the run.
        """
        path = Path(self.file)
        expect(path.is_file(), "file", self.file, "a file, and there is none")
        content = self._content(path)
        origin = Origin(path.name, hashlib.sha256(content).hexdigest())
        try:
            return self._read(content.decode("utf-8-sig"), epoch, duration, origin)
        except _Option as error:
            raise InvalidValue(error.key, error.value, error.expected) from None
        except ValueError as error:
            raise InvalidValue("file", self.file, f"{error}") from None

    def _content(self, path: Path) -> bytes:
        """What the file has, or the file in it if it is compressed by gzip."""
        with path.open("rb") as file:
            packed = file.read(2) == b"\x1f\x8b"
        try:
            with gzip.open(path) if packed else path.open("rb") as file:
                content = file.read(_MOST_BYTES + 1)
        except (gzip.BadGzipFile, EOFError, zlib.error) as error:
            raise InvalidValue("file", self.file, f"expected a sound .gz: {error}") from None
        size = f"at most {_MOST_BYTES} bytes, and there are more"
        expect(len(content) <= _MOST_BYTES, "file", self.file, size)
        return content

    def _read(
        self, text: str, epoch: datetime, duration: float, origin: Origin
    ) -> EphemerisOrbit | TLEOrbit | MeanElements:
        if is_element_file(text):
            self._expect_none("an ephemeris", "interpolation", "degree", "frame")
            return element_set(text, self.object, epoch, origin).for_run(epoch, duration)
        run = Run(epoch, duration, self.interpolation, self.degree)
        if self.file.lower().removesuffix(".gz").endswith(".csv"):
            self._expect_none("a file that names its objects", "object")
            try:
                frame = frame_name(self.frame)
            except ValueError as error:
                raise _Option("frame", self.frame, f"{error}") from None
            return ephemeris_of([read_position_table(text, epoch, frame)], run, origin)
        self._expect_none("a table .csv", "frame")
        return ephemeris_of(one_object(read_oem(text, epoch), self.object), run, origin)

    def _expect_none(self, of: str, *keys: str) -> None:
        for key in keys:
            if value := getattr(self, key):
                raise _Option(key, value, f"expected none: only {of} needs one")


class _Option(InvalidValue):
    """A key beside ``file`` that does not go with what the file is."""
