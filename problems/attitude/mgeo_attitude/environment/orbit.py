"""Orbits of a scenario: Keplerian elements, element sets, sampled ephemerides and files."""

from __future__ import annotations

import dataclasses
import gzip
import math
from datetime import datetime
from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import EARTH_RADIUS
from mgeo_attitude.environment.element_set import Angle, MeanElements, TLEOrbit
from mgeo_attitude.environment.ephemeris import MAX_DEGREE, EphemerisOrbit
from mgeo_attitude.environment.kepler import (
    Elements,
    j2_secular_rates,
    orbital_period,
    propagate_elements,
    propagate_j2_secular,
    propagate_two_body,
)
from mgeo_attitude.settings.base import Settings, TableClasses
from mgeo_attitude.settings.errors import InvalidValue, expect
from mgeo_attitude.settings.types import Degrees, Unit, restrict_to

#: Analytic propagators by the value of ``propagator`` in a scenario file.
ANALYTIC_PROPAGATORS = {"two-body": propagate_two_body, "j2": propagate_j2_secular}


@dataclass(frozen=True, kw_only=True)
class Orbit(Settings):
    """Orbit given by Keplerian elements in GCRS at the scenario's epoch. The elements are
    osculating for two-body motion, and mean elements if J2 drift is included.

    Raises
    ------
    InvalidValue
        If an element is out of range or the perigee is below the Earth's surface.

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

    propagator: Annotated[str, restrict_to(ANALYTIC_PROPAGATORS)] = "two-body"
    """two-body motion, or two-body motion with secular drift by J2"""
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
        """Keplerian orbital period [s]."""
        return orbital_period(self.semi_major_axis)

    def propagate(self, epoch: datetime, times: Floats) -> tuple[Floats, Floats]:
        """Compute position [m] and velocity [m/s] in GCRS at given times [s] after the epoch.

        Both arrays have shape (n, 3).
        """
        return ANALYTIC_PROPAGATORS[self.propagator](self._build_elements(), times)

    def shift_epoch(self, time: float) -> Self:
        """Return the orbit with its elements propagated to a new epoch, `time` seconds later."""
        elements = self._build_elements()
        rates = j2_secular_rates(*elements[:3]) if self.propagator == "j2" else (0.0, 0.0, 0.0)
        _, _, _, *angles = propagate_elements(elements, time, rates)
        raan, perigee, anomaly = (math.degrees(math.remainder(a, math.tau)) for a in angles)
        return dataclasses.replace(
            self, raan_deg=raan, argument_of_perigee_deg=perigee, true_anomaly_deg=anomaly
        )

    def prepare_for_run(self, epoch: datetime, duration: float) -> Self:
        """Return the orbit unchanged, because Keplerian elements are valid for any run."""
        return self

    def _build_elements(self) -> Elements:
        angles = (
            self.inclination_deg,
            self.raan_deg,
            self.argument_of_perigee_deg,
            self.true_anomaly_deg,
        )
        return Elements(self.semi_major_axis, self.eccentricity, *map(math.radians, angles))


@dataclass(frozen=True, kw_only=True)
class OrbitFile(Settings):
    """Reference to a file with element sets (OMM or two-line) or an orbit ephemeris message (OEM).

    Files may be compressed (``.gz``). A scenario stores the elements or samples that
    `prepare_for_run` returns, and does not depend on the file, which may change.

    Raises
    ------
    InvalidValue
        If a value is out of range.

    Examples
    --------
    >>> from mgeo_attitude.scenario import OrbitFile
    >>> OrbitFile(file="stations.omm", object="25544").object
    '25544'
    """

    selector: ClassVar[str] = "propagator"
    propagator: ClassVar[str] = "file"

    file: str
    """path of the file, relative to the scenario file"""
    object: str = ""
    """name, international designator or catalog number of the object, if the file contains several
    objects"""
    interpolation: Literal["hermite", "lagrange"] | None = None
    """interpolation of positions and velocities (hermite) or of positions only (lagrange); default:
    as specified in the file"""
    degree: int | None = Field(default=None, ge=1, le=MAX_DEGREE)
    """degree of the interpolating polynomials; default: as specified in the file"""

    def prepare_for_run(
        self, epoch: datetime, duration: float
    ) -> EphemerisOrbit | TLEOrbit | MeanElements:
        """Read the file and return the orbit for a run.

        The orbit is an element set, or an ephemeris with the samples that the run needs.

        Parameters
        ----------
        epoch : datetime with UTC offset
            Start of the run.
        duration : float
            Duration of the run [s].

        Raises
        ------
        OSError
            If the file cannot be read.
        InvalidValue
            If the file is invalid or does not cover the run. The message names the file.
        """
        from mgeo_attitude.environment.element_file import read_element_set
        from mgeo_attitude.environment.oem_file import TimeSpan, read_oem

        path = Path(self.file)
        expect(path.is_file(), "file", self.file, "an existing file")
        try:
            with gzip.open(path, "rt") if path.suffix == ".gz" else path.open() as file:
                text = file.read()
            if "CCSDS_OEM_VERS" in text or "<oem" in text:
                run = TimeSpan(epoch, duration)
                return read_oem(path, self.object, run, self.interpolation, self.degree)
            element_set = read_element_set(text, self.object, epoch, path.name)
        except (ValueError, EOFError, ImportError) as error:
            raise InvalidValue("file", self.file, f"{error}") from error
        kinds = "element sets (OMM, or two lines) or an orbit ephemeris message (OEM)"
        expect(element_set, "file", self.file, kinds)
        assert element_set is not None
        return element_set.prepare_for_run(epoch, duration)


AnyOrbit = Orbit | TLEOrbit | MeanElements | EphemerisOrbit

#: Orbit classes by the value of ``propagator`` in a scenario file. The keys ``line1`` and ``file``
#: imply the propagator.
ORBITS = TableClasses(
    "propagator",
    dict.fromkeys(ANALYTIC_PROPAGATORS, Orbit)
    | {cls.propagator: cls for cls in (TLEOrbit, MeanElements, EphemerisOrbit, OrbitFile)},
    default="two-body",
    identifying_keys={"line1": TLEOrbit.propagator, "file": OrbitFile.propagator},
)
