"""How the satellite moves: elements at the epoch, an element set, or an ephemeris."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from datetime import datetime
from typing import Self

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import EARTH_RADIUS
from mgeo_attitude.environment.ephemeris import EphemerisOrbit
from mgeo_attitude.environment.kepler import (
    Elements,
    advanced,
    j2_secular,
    orbital_period,
    secular_rates,
    two_body,
)
from mgeo_attitude.environment.mean_elements import MeanElements
from mgeo_attitude.environment.orbit_file import OrbitFile
from mgeo_attitude.environment.tle import TLEOrbit
from mgeo_attitude.fields import Kinds, Validated, expect, positive, quantity

#: Functions of Keplerian elements and times, by the ``propagator`` that names them.
ANALYTIC = {"two-body": two_body, "j2": j2_secular}


@dataclass(frozen=True, kw_only=True)
class Orbit(Validated):
    """Osculating (two-body) or mean (J2) Keplerian elements at the scenario's epoch, GCRS axes.

    Raises
    ------
    InvalidValue, InvalidType
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

    propagator: str = quantity(
        "two-body", choices=tuple(ANALYTIC), doc="unperturbed, or with the secular effects of J2"
    )
    semi_major_axis: float = positive(unit="m", doc="semi-major axis")
    eccentricity: float = quantity(low=0.0, high=1.0, open_high=True, doc="eccentricity")
    inclination_deg: float = quantity(unit="deg", low=0.0, high=180.0, doc="inclination")
    raan_deg: float = quantity(
        unit="deg", low=-360.0, high=360.0, doc="right ascension of the ascending node"
    )
    argument_of_perigee_deg: float = quantity(
        unit="deg", low=-360.0, high=360.0, doc="argument of perigee"
    )
    true_anomaly_deg: float = quantity(
        unit="deg", low=-360.0, high=360.0, doc="true anomaly at the epoch"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
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
