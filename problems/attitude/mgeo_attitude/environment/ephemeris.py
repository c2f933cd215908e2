"""Orbit by interpolation of positions that another tool has computed."""

from __future__ import annotations

from datetime import datetime
from functools import cached_property
from typing import Annotated, ClassVar, Self

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import EARTH_MU, EARTH_RADIUS
from mgeo_attitude.environment.interpolation import interpolate
from mgeo_attitude.environment.kepler import orbital_period
from mgeo_attitude.environment.times import format_instant, seconds_between
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import expect
from mgeo_attitude.settings.types import Instant, Unit, Vector

#: Default degree of the polynomials, for 8 positions or 4 positions with velocities.
DEFAULT_DEGREE = 7
MAX_DEGREE = 15
#: Largest difference between instants that are treated as equal [s]. Files round times, usually to
#: a microsecond.
TIME_TOLERANCE = 2e-6

#: Largest distance from the Earth [m]; the radius of its sphere of influence is 9.2e8 m.
_MAX_RADIUS = 1e9
#: Largest difference between interpolations [m], which is the error of the best element sets.
_MAX_INTERPOLATION_ERROR = 1000.0


@dataclass(frozen=True, kw_only=True)
class EphemerisOrbit(Settings):
    """Orbit interpolated from sampled positions in GCRS. Hermite interpolation is used if
    velocities are given, and Lagrange interpolation otherwise.

    Raises
    ------
    InvalidValue
        If times do not increase, if there are too few samples or arrays of different length, if a
        position is below ground or too far from the Earth, or if the orbit is not bound.

    Examples
    --------
    >>> import numpy as np
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.scenario import EphemerisOrbit
    >>> scenario = Scenario.paper()
    >>> times = np.arange(0.0, 1200.0, 60.0)
    >>> position, velocity = scenario.orbit.propagate(scenario.epoch, times)
    >>> rows = {"times": times, "position": position, "velocity": velocity}
    >>> samples = EphemerisOrbit(epoch=scenario.epoch, **{k: v.tolist() for k, v in rows.items()})
    >>> at_90_s = scenario.epoch, np.array([90.0])
    >>> at = [orbit.propagate(*at_90_s)[0] for orbit in (samples, scenario.orbit)]
    >>> bool(abs(at[0] - at[1]).max() < 1e-3)  # m
    True
    """

    selector: ClassVar[str] = "propagator"
    propagator: ClassVar[str] = "ephemeris"

    source: str = ""
    """origin of the samples, such as the name of a file"""
    epoch: Instant
    """reference epoch of `times`, with UTC offset"""
    degree: int = Field(default=DEFAULT_DEGREE, ge=1, le=MAX_DEGREE)
    """degree of the interpolating polynomials"""
    times: Annotated[tuple[float, ...], Unit("s")]
    """times of the samples after the epoch, in increasing order"""
    position: Annotated[tuple[Vector, ...], Unit("m")]
    """positions in GCRS"""
    velocity: Annotated[tuple[Vector, ...], Unit("m/s")] = ()
    """velocities in GCRS; without velocities, Lagrange interpolation is used"""

    def __post_init__(self) -> None:
        n, n_needed = (
            len(self.times),
            max(3, count_polynomial_samples(self.degree, bool(self.velocity)) + 1),
        )
        expected_count = (
            f"at least {n_needed} for degree = {self.degree}. Reduce the degree or add samples"
        )
        expect(n >= n_needed, "times", f"{n} samples", expected_count)
        for key, count in (("position", len(self.position)), ("velocity", len(self.velocity) or n)):
            expect(count == n, key, f"{count} vectors", f"{n}, one per time")
        for k in np.flatnonzero(np.diff(self.times) <= 0.0)[:1] + 1:
            expected = f"more than the previous time, {self.times[k - 1]!r} s"
            expect(False, f"times[{k}]", self.times[k], expected)
        radius = np.linalg.norm(self.position, axis=1)
        for k in np.flatnonzero((radius < EARTH_RADIUS) | (radius > _MAX_RADIUS))[:1]:
            expected = (
                f"a position above ground and near the Earth, |r| from {EARTH_RADIUS:.12g} to "
                f"{_MAX_RADIUS:g} m, not {radius[k]:.6g} m"
            )
            expect(False, f"position[{k}]", self.position[k], expected)
        bound = "a position and a speed of a bound orbit about the Earth"
        for k in np.flatnonzero(self._energies >= 0.0)[:1]:
            expect(False, f"position[{k}]", self.position[k], bound)

    @property
    def period(self) -> float:
        """Keplerian period [s] at the mean semi-major axis of the samples."""
        return orbital_period(float(np.mean(-0.5 * EARTH_MU / self._energies)))

    def propagate(self, epoch: datetime, times: Floats) -> tuple[Floats, Floats]:
        """Interpolate position [m] and velocity [m/s] in GCRS at given times [s] after an epoch.

        Both arrays have shape (n, 3). The velocity is the derivative of the interpolated position.
        """
        return self._interpolate(times + seconds_between(self.epoch, epoch))

    def prepare_for_run(self, epoch: datetime, duration: float) -> Self:
        """Return the orbit after checking that its samples cover a whole run and are consistent.

        Raises
        ------
        InvalidValue
            If the samples do not cover the run, or if polynomials through different neighboring
            samples differ by 1 km or more during the run. Possible causes are a wrong sample, too
            few samples, velocities that do not match the positions, and a maneuver.
        """
        start = seconds_between(self.epoch, epoch)
        end, (first, *_, last) = start + duration, self.times
        inside = first <= start + TIME_TOLERANCE and end <= last + TIME_TOLERANCE
        run = (
            f"samples for the whole run, from {start:.12g} to {end:.12g} s after "
            f"orbit.epoch = {self.epoch.isoformat()}"
        )
        expect(inside, "times", f"{first:.12g} to {last:.12g}", run)
        times = np.array(self.times)
        middle = 0.5 * (times[1:] + times[:-1])
        needed = np.flatnonzero((times[1:] > start) & (times[:-1] < end))
        shifted, _ = self._interpolate(middle[needed], shift=1)
        error = np.linalg.norm(shifted - self._interpolate(middle[needed])[0], axis=1)
        worst = int(np.argmax(error))
        begin, stop = (
            format_instant(self.epoch, self.times[needed[worst] + side]) for side in (0, 1)
        )
        agreement = (
            f"polynomials of degree {self.degree} through neighboring samples that agree to "
            f"{_MAX_INTERPOLATION_ERROR:g} m, not {error[worst]:.3g} m: a sample is wrong, samples "
            "are too far apart, velocities have another unit or frame, or there is a maneuver. "
            "Start the run after the maneuver, or remove the samples after it"
        )
        expect(error[worst] < _MAX_INTERPOLATION_ERROR, "times", f"{begin} to {stop}", agreement)
        return self

    def shift_epoch(self, time: float) -> Self:
        """Return the orbit unchanged, because its epoch does not depend on the scenario's start."""
        return self

    def _interpolate(self, times: Floats, shift: int = 0) -> tuple[Floats, Floats]:
        count = count_polynomial_samples(self.degree, bool(self.velocity))
        return interpolate(*self._samples, count, times, shift)

    @cached_property
    def _samples(self) -> tuple[Floats, Floats, Floats | None]:
        velocity = np.array(self.velocity) if self.velocity else None
        return np.array(self.times), np.array(self.position), velocity

    @cached_property
    def _energies(self) -> Floats:
        """Specific orbital energy of each sample [m²/s²], shape (n,)."""
        times, position, velocity = self._samples
        velocity = self._interpolate(times)[1] if velocity is None else velocity
        kinetic = 0.5 * np.einsum("ni,ni->n", velocity, velocity)
        return np.asarray(kinetic - EARTH_MU / np.linalg.norm(position, axis=1))


def count_polynomial_samples(degree: int, has_velocities: bool) -> int:
    """Return the number of samples that determine a polynomial of a given degree.

    Each sample determines one coefficient, or two coefficients if it has a velocity.
    """
    return (degree + 2) // 2 if has_velocities else degree + 1
