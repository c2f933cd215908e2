"""Environment of a run at each filter sample: orbit, Sun direction, geomagnetic field and
eclipses.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import lru_cache
from typing import Protocol, Self

import numpy as np

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.environment.constants import FIELD_MODEL_END, FIELD_MODEL_START
from mgeo_attitude.environment.field import dipole_gradient, field_gradient, geomagnetic_field
from mgeo_attitude.environment.frames import gcrs_to_itrs, rotate
from mgeo_attitude.environment.orbit import AnyOrbit
from mgeo_attitude.environment.sun_moon import sun_direction, sun_position, visible_sun_fraction
from mgeo_attitude.environment.times import compute_julian_dates
from mgeo_attitude.settings.base import require_same

#: Fields of a `Scenario` that determine its environment.
SCENARIO_FIELDS = ("epoch", "duration", "step", "orbit")


class OrbitSource(Protocol):
    """Protocol of an object with an orbit, an epoch and sample times, such as a `Scenario`.

    If the object has an attribute `needs_field` that is false, its times may be outside of the
    years of the field model.
    """

    @property
    def epoch(self) -> datetime: ...
    @property
    def step(self) -> float: ...
    @property
    def orbit(self) -> AnyOrbit: ...
    @property
    def times(self) -> Floats: ...


@dataclass(frozen=True, eq=False)
class Environment:
    """Satellite position and velocity, Sun direction, magnetic field and eclipses at each sample.

    The arrays are read-only and have one row per sample. All vectors are in GCRS.

    Attributes
    ----------
    times : array (n,)
        Seconds since the epoch, increasing.
    position, velocity : array (n, 3)
        Position [m] and velocity [m/s] of the satellite.
    sun : array (n, 3)
        Geometric unit vectors from the satellite to the Sun.
    field : array (n, 3)
        Geomagnetic field [nT].
    sunlit : array (n,) of bool
        False where the Earth covers more than half of the Sun's disc.
    origin : OrbitSource, optional
        Object from which the environment was computed; None for user-defined arrays.
    albedo : array (n, 3), optional
        Albedo of the Earth as a vector that is added to the Sun's unit vector, see `albedo_vector`.
    has_eclipses : bool
        Whether eclipses are modeled. Without them, all samples are sunlit.
    epoch : datetime, optional
        Epoch of `times` if the field is computed from IGRF; None for a user-defined field.

    Raises
    ------
    ValueError
        If an array has the wrong shape, NaN or infinity, if times do not increase, or if `sun` is
        not of unit length.

    Examples
    --------
    >>> import numpy as np
    >>> from mgeo_attitude import Environment, Scenario
    >>> environment = Environment.from_scenario(Scenario.paper())
    >>> environment.position.shape, float(np.linalg.norm(environment.field[0]).round(-2))
    ((11985, 3), 29600.0)
    """

    times: Floats
    position: Floats
    velocity: Floats
    sun: Floats
    field: Floats
    sunlit: Bools
    origin: OrbitSource | None = None
    albedo: Floats | None = None
    has_eclipses: bool = True
    epoch: datetime | None = None

    def __post_init__(self) -> None:
        n = np.size(self.times)
        shapes = {"times": (n,), "sunlit": (n,)}
        optional = () if self.albedo is None else ("albedo",)
        for name in ("times", "position", "velocity", "sun", "field", "sunlit", *optional):
            shape = shapes.get(name, (n, 3))
            table = np.array(getattr(self, name), dtype=bool if name == "sunlit" else float)
            if table.shape != shape or not np.isfinite(table).all():
                expected = f"expected an array of shape {shape} of finite numbers"
                raise ValueError(f"{name}: {expected}, not {table.shape} {table!r:.200}")
            table.setflags(write=False)
            object.__setattr__(self, name, table)
        if n == 0 or not (np.diff(self.times) > 0.0).all():
            raise ValueError("times: expected at least one instant, in increasing order [s]")
        if np.abs(np.linalg.norm(self.sun, axis=1) - 1.0).max() > 1e-9:
            raise ValueError("sun: expected unit vectors from the satellite to the Sun")

    @classmethod
    def from_scenario(cls, scenario: OrbitSource) -> Self:
        """Compute the environment at the sample times of a scenario.

        The computation takes about 0.7 s for two orbits at a step of 1 s.

        Raises
        ------
        ValueError
            If a run that needs the field is outside of the years of the field model, or if the
            orbit enters the Earth.
        ImportError, SGP4Error
            If an element set cannot be propagated; see `ElementSet`.
        """
        return cls.from_times(scenario, scenario.times, origin=scenario)

    @classmethod
    def from_times(
        cls,
        scenario: OrbitSource,
        times: Floats,
        position: Floats | None = None,
        origin: OrbitSource | None = None,
    ) -> Self:
        """Compute the environment at given times [s] after a scenario's epoch.

        Parameters
        ----------
        scenario : OrbitSource
        times : array, shape (n,)
        position : array, shape (n, 3), optional
            Position of the satellite [m], GCRS. Default: the position on the scenario's orbit.
        origin : OrbitSource, optional
            Value of the attribute `origin`.

        Raises
        ------
        ValueError, ImportError, SGP4Error
            In the same cases as `from_scenario`.
        """
        if position is None:
            position, velocity = scenario.orbit.propagate(scenario.epoch, times)
        else:
            velocity = np.gradient(position, times, axis=0)
        needs_field = getattr(scenario, "needs_field", True)
        sun, field = _compute_cached_sun_and_field(
            scenario.epoch, _to_bytes(times), _to_bytes(position), needs_field
        )
        return cls(
            times=times,
            position=position,
            velocity=velocity,
            sun=sun_direction(position, sun),
            field=field,
            sunlit=visible_sun_fraction(position, sun) >= 0.5,
            origin=origin,
            epoch=scenario.epoch,
        )

    def field_gradient(self) -> Floats:
        """Compute the gradient of the geomagnetic field [nT/m] in GCRS, shape (n, 3, 3).

        The gradient of a user-defined field is that of a dipole, see `dipole_gradient`.
        """
        if self.epoch is None:
            return dipole_gradient(self.position, self.field)
        return _compute_cached_field_gradient(
            self.epoch, _to_bytes(self.times), _to_bytes(self.position)
        )

    @property
    def field_tesla(self) -> Floats:
        """Geomagnetic field [T], shape (n, 3)."""
        return 1e-9 * self.field

    def without_eclipses(self) -> Self:
        """Return a copy in which the satellite is always in sunlight."""
        return dataclasses.replace(self, sunlit=np.ones_like(self.sunlit), has_eclipses=False)

    def validate_scenario(self, scenario: OrbitSource) -> None:
        """Raise ValueError if the environment does not match a scenario.

        The orbit, epoch, duration and step must be equal. User-defined arrays only need the times
        of the scenario.

        Raises
        ------
        ValueError
            If a field of `SCENARIO_FIELDS` or the times differ. The message names the first
            difference and both values.
        """
        if self.origin is not None:
            require_same("environment", self.origin, scenario, SCENARIO_FIELDS)
        if not np.array_equal(self.times, scenario.times):
            times = self.times
            raise ValueError(
                f"environment.times: {len(times)} samples from {times[0]:g} to {times[-1]:g} s: "
                f"expected the scenario's {len(scenario.times)}, one every {scenario.step:g} s"
            )


def _to_bytes(table: Floats) -> bytes:
    return np.asarray(table, dtype=np.float64).tobytes()


def _compute_middle_epoch(epoch: datetime, times: Floats) -> datetime:
    return epoch + timedelta(seconds=0.5 * float(times[0] + times[-1]))


def compute_sun_and_field(
    epoch: datetime, times: Floats, position: Floats, needs_field: bool = True
) -> tuple[Floats, Floats]:
    """Compute the Sun position [m] and the geomagnetic field [nT] at given times and positions.

    The two arrays take most of the computing time of an `Environment`. If `needs_field` is false, a
    date outside of the years of the field model is replaced by the nearest date inside.

    Parameters
    ----------
    epoch : datetime
    times : array, shape (n,)
        Times after the epoch [s], nondecreasing.
    position : array, shape (n, 3)
        Position of the satellite [m], GCRS.
    needs_field : bool
        Whether the run depends on the field; false if only figures show it.

    Returns
    -------
    sun, field : arrays, shape (n, 3)
        Vectors from Earth to Sun [m] and field [nT], GCRS.
    """
    at = compute_julian_dates(epoch, times)
    to_itrs = gcrs_to_itrs(at)
    middle = _compute_middle_epoch(epoch, times)
    if not needs_field:
        middle = min(max(middle, FIELD_MODEL_START), FIELD_MODEL_END)
    # The field is computed first, since it raises an error for dates for which the Sun position
    # only causes a warning.
    field = geomagnetic_field(rotate(to_itrs, position), middle)
    return sun_position(at), rotate(np.swapaxes(to_itrs, 1, 2), field)


# A problem, its plans and their Monte Carlo runs request the same arrays independently.
@lru_cache(maxsize=16)
def _compute_cached_sun_and_field(
    epoch: datetime, times: bytes, position: bytes, needs_field: bool
) -> tuple[Floats, Floats]:
    seconds, positions = np.frombuffer(times), np.frombuffer(position).reshape(-1, 3)
    tables = compute_sun_and_field(epoch, seconds, positions, needs_field)
    for table in tables:
        table.flags.writeable = False  # The cached array is shared.
    return tables


# Each magnetometer requests the gradient.
@lru_cache(maxsize=16)
def _compute_cached_field_gradient(epoch: datetime, times: bytes, position: bytes) -> Floats:
    seconds, positions = np.frombuffer(times), np.frombuffer(position).reshape(-1, 3)
    to_itrs = gcrs_to_itrs(compute_julian_dates(epoch, seconds))
    gradient = field_gradient(rotate(to_itrs, positions), _compute_middle_epoch(epoch, seconds))
    rotated: Floats = np.swapaxes(to_itrs, 1, 2) @ gradient @ to_itrs
    rotated.flags.writeable = False
    return rotated
