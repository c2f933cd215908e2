"""How the satellite moves: elements, an element set, an ephemeris, or a file of another tool."""

from __future__ import annotations

import dataclasses
import gzip
import hashlib
import math
import zlib
from datetime import datetime
from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import EARTH_RADIUS
from mgeo_attitude.environment.element_set import Angle, MeanElements, TLEOrbit
from mgeo_attitude.environment.ephemeris import MOST_DEGREE, EphemerisOrbit
from mgeo_attitude.environment.frames import frame_name
from mgeo_attitude.environment.kepler import (
    Elements,
    advanced,
    j2_secular,
    orbital_period,
    secular_rates,
    two_body,
)
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, expect
from mgeo_attitude.settings.tables import Kinds
from mgeo_attitude.settings.types import Degrees, Unit, one_of

#: Functions of Keplerian elements and times, by the ``propagator`` that names them.
ANALYTIC = {"two-body": two_body, "j2": j2_secular}


@dataclass(frozen=True, kw_only=True)
class Orbit(Settings):
    """Osculating (two-body) or mean (J2) Keplerian elements at the scenario's epoch, GCRS axes.

    Raises
    ------
    InvalidValue
        For an element out of its range, or a perigee below the Earth's surface.

    Examples
    --------
    >>> from mgeo_attitude.scenario import Orbit
    >>> orbit = Orbit(
    ...     semi_major_axis=6.9e6,
    ...     eccentricity=0.001,
    ...     inclination_deg=97.5,
    ...     raan_deg=10.0,
    ...     argument_of_perigee_deg=0.0,
    ...     true_anomaly_deg=0.0,
    ... )
    >>> round(orbit.period)  # s
    5704
    """

    propagator: Annotated[str, one_of(ANALYTIC)] = "two-body"
    """unperturbed, or with the secular effects of J2"""
    semi_major_axis: Annotated[float, Unit("m")] = Field(gt=0.0)
    """semi-major axis"""
    eccentricity: float = Field(ge=0.0, lt=1.0)
    """eccentricity"""
    inclination_deg: Degrees = Field(ge=0.0, le=180.0)
    """inclination"""
    raan_deg: Angle
    """right ascension of the ascending node"""
    argument_of_perigee_deg: Angle
    """argument of perigee"""
    true_anomaly_deg: Angle
    """true anomaly at the epoch"""

    def __post_init__(self) -> None:
        perigee = self.semi_major_axis * (1.0 - self.eccentricity)
        above = (
            "a perigee above the Earth's surface, semi_major_axis * (1 - eccentricity) > "
            f"{EARTH_RADIUS:.12g} m, not {perigee:.12g} m"
        )
        expect(perigee > EARTH_RADIUS, "semi_major_axis", self.semi_major_axis, above)

    @property
    def period(self) -> float:
        """Keplerian period [s]."""
        return orbital_period(self.semi_major_axis)

    def propagate(self, epoch: datetime, times: Floats) -> tuple[Floats, Floats]:
        """Position [m] and velocity [m/s], shape (n, 3), at `times` [s] after the epoch."""
        return ANALYTIC[self.propagator](self._elements(), times)

    def later(self, time: float) -> Self:
        """The same orbit with the elements of an epoch `time` [s] later."""
        elements = self._elements()
        rates = secular_rates(*elements[:3]) if self.propagator == "j2" else (0.0, 0.0, 0.0)
        _, _, _, *angles = advanced(elements, time, rates)
        raan, perigee, anomaly = (math.degrees(math.remainder(a, math.tau)) for a in angles)
        return dataclasses.replace(
            self, raan_deg=raan, argument_of_perigee_deg=perigee, true_anomaly_deg=anomaly
        )

    def for_run(self, epoch: datetime, duration: float) -> Self:
        """Itself: the elements are those of the epoch, whatever it is."""
        return self

    def _elements(self) -> Elements:
        angles = (
            self.inclination_deg,
            self.raan_deg,
            self.argument_of_perigee_deg,
            self.true_anomaly_deg,
        )
        return Elements(self.semi_major_axis, self.eccentricity, *map(math.radians, angles))


_MOST_BYTES = 2**26


@dataclass(frozen=True, kw_only=True)
class OrbitFile(Settings):
    """Element sets (OMM, or two lines), an orbit ephemeris message (OEM in KVN), or a table of
    positions (``.csv``); each also compressed (``.gz``).

    What it is, it says itself. A scenario keeps the elements or samples that `for_run` gives, and
    not the file, which may change.

    Raises
    ------
    InvalidValue
        For a value out of its range.

    Examples
    --------
    >>> from mgeo_attitude.scenario import OrbitFile
    >>> OrbitFile(file="stations.omm", object="25544").object
    '25544'
    """

    selector: ClassVar[str] = "propagator"
    propagator: ClassVar[str] = "file"

    file: str
    """element sets or an ephemeris, in the scenario file's folder"""
    object: str = ""
    """which of several objects: name, designator or catalog number"""
    frame: str = ""
    """frame of a table: GCRF, EME2000, TEME, TOD, MOD or ITRF"""
    interpolation: Literal["hermite", "lagrange"] | None = None
    """through velocities too, or positions only, if not as the file says"""
    degree: int | None = Field(default=None, ge=1, le=MOST_DEGREE)
    """degree of the polynomials, if not as the file says"""

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
        try:
            return self._read(content, epoch, duration)
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
        self, content: bytes, epoch: datetime, duration: float
    ) -> EphemerisOrbit | TLEOrbit | MeanElements:
        from mgeo_attitude.environment.element_file import element_set, is_element_file
        from mgeo_attitude.environment.ephemeris_file import Run, ephemeris_of, one_object
        from mgeo_attitude.environment.ephemeris_formats import (
            Origin,
            read_oem,
            read_position_table,
        )

        text = content.decode("utf-8-sig")
        origin = Origin(Path(self.file).name, hashlib.sha256(content).hexdigest())
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


AnyOrbit = Orbit | TLEOrbit | MeanElements | EphemerisOrbit

#: Orbit classes by the ``propagator`` that names them in a scenario file, which some keys say, too.
#: `for_run` gives the orbit of a run, which has a `period` and `propagate`.
ORBITS = Kinds(
    "propagator",
    dict.fromkeys(ANALYTIC, Orbit)
    | {cls.propagator: cls for cls in (TLEOrbit, MeanElements, EphemerisOrbit, OrbitFile)}
    | {"ephemeris-file": OrbitFile},  # its name when it read ephemerides only
    default="two-body",
    telling={"line1": TLEOrbit.propagator, "file": OrbitFile.propagator},
)
