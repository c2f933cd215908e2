"""An element set by its numbers, as orbit mean-elements messages have them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING, ClassVar

from mgeo_attitude.environment.constants import DAY
from mgeo_attitude.environment.element_set import ElementSet, fastest, sgp4_api
from mgeo_attitude.fields import expect, positive, quantity

if TYPE_CHECKING:
    from sgp4.api import Satrec

#: From which `Satrec.sgp4init` counts days.
_ZERO = datetime(1949, 12, 31, tzinfo=UTC)


@dataclass(frozen=True, kw_only=True)
class MeanElements(ElementSet):
    """Mean elements of SGP4 (TEME, mean motion of Kozai), propagated from their own epoch.

    Raises
    ------
    InvalidValue, InvalidType
        For an element out of its range, or a perigee below the Earth's surface.

    Examples
    --------
    >>> from datetime import UTC, datetime
    >>> from mgeo_attitude.scenario import MeanElements
    >>> elements = MeanElements(
    ...     epoch=datetime(2008, 9, 20, 12, 25, tzinfo=UTC),
    ...     mean_motion_rev_day=15.72,
    ...     eccentricity=0.00067,
    ...     inclination_deg=51.64,
    ...     raan_deg=247.46,
    ...     argument_of_perigee_deg=130.54,
    ...     mean_anomaly_deg=325.03,
    ... )
    >>> round(elements.period)  # s
    5496
    """

    propagator: ClassVar[str] = "mean-elements"
    epoch_key: ClassVar[str] = "epoch"

    source: str | None = quantity(None, doc="where they come from")
    epoch: datetime = quantity(doc="instant of the elements, with its UTC offset")
    mean_motion_rev_day: float = positive(unit="rev/day", doc="mean motion")
    eccentricity: float = quantity(low=0.0, high=1.0, open_high=True, doc="eccentricity")
    inclination_deg: float = quantity(unit="deg", low=0.0, high=180.0, doc="inclination")
    raan_deg: float = quantity(
        unit="deg", low=-360.0, high=360.0, doc="right ascension of the ascending node"
    )
    argument_of_perigee_deg: float = quantity(
        unit="deg", low=-360.0, high=360.0, doc="argument of perigee"
    )
    mean_anomaly_deg: float = quantity(unit="deg", low=-360.0, high=360.0, doc="mean anomaly")
    bstar: float = quantity(0.0, unit="1/Earth radii", doc="drag term")

    def __post_init__(self) -> None:
        super().__post_init__()
        offset = self.epoch.utcoffset() is not None
        expect(offset, "epoch", self.epoch.isoformat(), "a UTC offset, such as a Z at the end")
        most = fastest(self.eccentricity)
        above = f"a perigee above the Earth's surface, at most {most:.6g} revolutions a day"
        found = self.mean_motion_rev_day
        expect(found < most, "mean_motion_rev_day", found, above)

    @property
    def instant(self) -> datetime:
        """The epoch."""
        return self.epoch.astimezone(UTC)

    @property
    def revolutions(self) -> float:
        """Mean motion [revolutions a day]."""
        return self.mean_motion_rev_day

    def satellite(self) -> Satrec:
        """With the constants of WGS72, for which element sets are made.

        Its number, which changes nothing, is 0: the package has none above 339999.
        """
        api = sgp4_api()
        satellite: Satrec = api.Satrec()
        satellite.sgp4init(
            api.WGS72,
            "i",
            0,
            (self.instant - _ZERO).total_seconds() / DAY,
            self.bstar,
            0.0,  # its derivatives are of older theories
            0.0,
            self.eccentricity,
            math.radians(self.argument_of_perigee_deg),
            math.radians(self.inclination_deg),
            math.radians(self.mean_anomaly_deg),
            self.mean_motion_rev_day * math.tau / 1440.0,
            math.radians(self.raan_deg),
        )
        return satellite
