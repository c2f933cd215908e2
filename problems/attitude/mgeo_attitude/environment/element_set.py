"""Mean elements, propagated by SGP4 (package `sgp4`, an extra), in GCRS.

SGP4 itself is good to about 1 km at the epoch of the set and loses 1 to 3 km a day; the rotation
from its frame adds less than 1 m.
"""

from __future__ import annotations

import math
from datetime import datetime, timedelta
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import DAY, EARTH_MU, EARTH_RADIUS
from mgeo_attitude.environment.time_frames import (
    Instants,
    instants,
    rotate,
    teme_to_gcrs,
    utc_text,
)
from mgeo_attitude.fields import InvalidValue, Validated, expect

if TYPE_CHECKING:
    from sgp4.api import Satrec

#: An element set older than this places the satellite tens of kilometers off and more.
MAX_AGE = timedelta(days=30)

_PROBE = 10.0  # s between the instants at which a run is tried; a dive into the ground takes longer
_MOST_PROBES = 100_000


class SGP4Error(ArithmeticError):
    """SGP4 cannot propagate an element set to the wanted instant."""


class ElementSet(Validated):
    """Mean elements for SGP4, with an epoch of their own; a class says how they are given."""

    #: The key that has the epoch.
    epoch_key: ClassVar[str]

    @property
    def instant(self) -> datetime:
        """Epoch of the elements, UTC."""
        raise NotImplementedError

    @property
    def revolutions(self) -> float:
        """Mean motion [revolutions a day]."""
        raise NotImplementedError

    def satellite(self) -> Satrec:
        """What SGP4 propagates; without the package sgp4 it is an ImportError."""
        raise NotImplementedError

    @property
    def period(self) -> float:
        """Period of the mean motion [s]."""
        return DAY / self.revolutions

    def propagate(self, epoch: datetime, times: Floats) -> tuple[Floats, Floats]:
        """As `gcrs_of`, at `times` [s] after the epoch."""
        return gcrs_of(self.satellite(), instants(epoch, times))

    def for_run(self, epoch: datetime, duration: float) -> Self:
        """Itself, or an InvalidValue.

        For an epoch that the set is too old, or too new, for, a satellite that decays within the
        run, or whatever else SGP4 reports in it, and a missing package sgp4.
        """
        key, value = self.epoch_key, getattr(self, self.epoch_key)
        value = value.isoformat() if isinstance(value, datetime) else value
        near = (
            f"an element set within {MAX_AGE.days} days of epoch = {epoch.isoformat()}, not of "
            f"{self.instant.isoformat()}"
        )
        expect(abs(epoch - self.instant) <= MAX_AGE, key, value, near)
        count = min(_MOST_PROBES, 2 + int(duration / _PROBE))
        times = np.linspace(0.0, duration, count)
        try:
            codes, _, _ = _states(self.satellite(), instants(epoch, times))
        except ImportError as error:
            raise InvalidValue(key, value, f"{error}") from None
        for k in np.flatnonzero(codes)[:1]:
            lasting = (
                "an element set that SGP4 propagates through the run; at "
                f"{utc_text(epoch, times[k])}, t = {times[k]:.0f} s, it says: "
                f"{_said(int(codes[k]))}"
            )
            expect(False, key, value, lasting)
        return self

    def later(self, time: float) -> Self:
        """Itself: it has an epoch of its own."""
        return self


def gcrs_of(satellite: Satrec, at: Instants) -> tuple[Floats, Floats]:
    """Position [m] and velocity [m/s], GCRS, shape (n, 3), by SGP4.

    The velocity takes TEME as inertial, which costs 1e-4 m/s in a low orbit. A decayed satellite,
    or what else SGP4 reports, is an SGP4Error.
    """
    position, velocity = teme_of(satellite, at)
    rotation = teme_to_gcrs(at)
    return rotate(rotation, position), rotate(rotation, velocity)


def teme_of(satellite: Satrec, at: Instants) -> tuple[Floats, Floats]:
    """As `gcrs_of`, in SGP4's own frame, the true equator and mean equinox of date."""
    codes, position, velocity = _states(satellite, at)
    for k in np.flatnonzero(codes)[:1]:
        code = int(codes[k])
        name = f"satellite {satellite.satnum_str}: " if satellite.satnum else ""
        raise SGP4Error(
            f"{name}SGP4 error {code} at t = {(at.ut[k] - at.ut[0]) * DAY:.1f} s, {_said(code)}"
        )
    return 1e3 * position, 1e3 * velocity


def sgp4_api() -> Any:
    """The package's module of classes and constants."""
    try:
        import sgp4.api as api
    except ImportError as error:
        raise ImportError("an element set needs the package sgp4: pip install sgp4") from error
    return api


def fastest(eccentricity: float) -> float:
    """Revolutions a day with the perigee at the Earth's surface."""
    return DAY * math.sqrt(EARTH_MU * ((1.0 - eccentricity) / EARTH_RADIUS) ** 3) / math.tau


def _states(satellite: Satrec, at: Instants) -> tuple[Floats, Floats, Floats]:
    codes, position, velocity = satellite.sgp4_array(np.full_like(at.ut, at.midnight), at.ut)
    return codes, position, velocity


def _said(code: int) -> str:
    return str(sgp4_api().SGP4_ERRORS[code])
