"""Physical constants in SI units, each with its source."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Final

#: Seconds in a day.
DAY: Final = 86400.0

#: Gravitational parameter of the Earth [m³/s²]: EGM2008 (Pavlis et al. 2012), as in JGM-3, EGM96.
EARTH_MU: Final = 3.986004415e14

#: Equatorial radius of the Earth [m]: the reference radius of EGM2008, to which J2 belongs.
EARTH_RADIUS: Final = 6378136.3

#: Second zonal harmonic: EGM2008 (tide-free), -√5 times its normalized C20.
EARTH_J2: Final = 1.0826261738522e-3

#: Nominal radius of the Sun [m]: IAU 2015 resolution B3.
SUN_RADIUS: Final = 6.957e8

#: Astronomical unit [m]: IAU 2012 resolution B2.
ASTRONOMICAL_UNIT: Final = 149597870700.0

#: Validity of the field model IGRF-14 (IAGA 2024), including its predictive part.
FIELD_MODEL_START: Final = datetime(1900, 1, 1, tzinfo=UTC)
FIELD_MODEL_END: Final = datetime(2030, 1, 1, tzinfo=UTC)
