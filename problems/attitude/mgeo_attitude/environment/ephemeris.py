"""An orbit that somebody else has computed: positions at instants, interpolated in between."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from typing import ClassVar, Self

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.constants import EARTH_MU, EARTH_RADIUS
from mgeo_attitude.environment.interpolation import interpolate, nearest, others
from mgeo_attitude.environment.kepler import orbital_period
from mgeo_attitude.environment.time_frames import elapsed
from mgeo_attitude.fields import Validated, expect, quantity

#: Degree of the polynomials if nobody says one: through 8 positions, or 4 with velocities.
DEFAULT_DEGREE = 7
MOST_DEGREE = 15
#: Instants this near [s] are the same: files round theirs, mostly to a microsecond.
SAME_INSTANT = 2e-6

_GAP = 4.0  # times the usual distance of samples
_FARTHEST = 1e9  # m; the Earth's gravity rules as far as 9.2e8 m (its sphere of influence)
_MOST_MISSED = 1000.0  # m, as much as the best element sets are off
_BLOCK = 50_000  # instants interpolated at once; bounds memory

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class EphemerisOrbit(Validated):
    """Samples of a position in GCRS: Hermite's polynomials with velocities, Lagrange's without.

    Raises
    ------
    InvalidValue, InvalidType
        For times that do not increase or have a gap, too few samples, unequal numbers of them, a
        position below ground or beyond the Earth's reach, a satellite that the Earth does not hold,
        or a sample that those around it miss by more than 1 km: it is wrong, they are too far
        apart, or the velocities are not those of the positions.
    """

    propagator: ClassVar[str] = "ephemeris"

    source: str = quantity("", doc="where the samples come from")
    epoch: datetime = quantity(doc="instant from which the times count, with its UTC offset")
    degree: int = quantity(DEFAULT_DEGREE, low=1, high=MOST_DEGREE, doc="degree of the polynomials")
    times: tuple[float, ...] = quantity(unit="s", doc="SI seconds after the epoch, increasing")
    position: tuple[Vector, ...] = quantity(unit="m", doc="positions, GCRS")
    velocity: tuple[Vector, ...] = quantity((), unit="m/s", doc="velocities, GCRS, if known")

    def __post_init__(self) -> None:
        super().__post_init__()
        offset = self.epoch.utcoffset() is not None
        expect(offset, "epoch", self.epoch.isoformat(), "a UTC offset, such as a Z at the end")
        n, need = len(self.times), self._points + 1
        expect(n >= need, "times", f"{n} samples", f"at least {need} for degree = {self.degree}")
        for key, count in (("position", len(self.position)), ("velocity", len(self.velocity) or n)):
            expect(count == n, key, f"{count} vectors", f"{n}, one for each of the times")
        self._check_times()
        self._check_positions()

    @property
    def period(self) -> float:
        """Keplerian period [s] of the mean of the samples' osculating semi-major axes."""
        return orbital_period(float(np.mean(-0.5 * EARTH_MU / self._energies())))

    def propagate(self, epoch: datetime, times: Floats) -> tuple[Floats, Floats]:
        """Position [m] and its slope [m/s], GCRS, shape (n, 3), at `times` [s] after the epoch."""
        at = times + elapsed(self.epoch, epoch)
        blocks = np.array_split(at, 1 + len(at) // _BLOCK)
        position, velocity = zip(*map(self._at, blocks), strict=True)
        return np.concatenate(position), np.concatenate(velocity)

    def for_run(self, epoch: datetime, duration: float) -> Self:
        """Itself, or an InvalidValue if its samples do not reach from start to end of a run."""
        start = elapsed(self.epoch, epoch)
        first, last = self.times[0], self.times[-1]
        inside = first <= start + SAME_INSTANT and start + duration <= last + SAME_INSTANT
        run = (
            f"samples for the whole run, from {start:.12g} to {start + duration:.12g} s after "
            f"orbit.epoch = {self.epoch.isoformat()}"
        )
        expect(inside, "times", f"{first:.12g} to {last:.12g}", run)
        return self

    def later(self, time: float) -> Self:
        """Itself: it has an epoch of its own."""
        return self

    @property
    def _points(self) -> int:
        return points(self.degree, bool(self.velocity))

    @cached_property
    def _samples(self) -> tuple[Floats, Floats, Floats | None]:
        velocity = np.array(self.velocity) if self.velocity else None
        return np.array(self.times), np.array(self.position), velocity

    def _at(self, at: Floats) -> tuple[Floats, Floats]:
        return interpolate(*self._samples, nearest(self._samples[0], at, self._points), at)

    def _energies(self) -> Floats:
        """Of the samples, kinetic and potential [m²/s²], shape (n,)."""
        position, velocity = self._at(self._samples[0])
        kinetic = 0.5 * np.einsum("ni,ni->n", velocity, velocity)
        return np.asarray(kinetic - EARTH_MU / np.linalg.norm(position, axis=1))

    def _check_times(self) -> None:
        steps = np.diff(self.times)
        most = _GAP * float(np.median(steps))
        for k, step in enumerate(steps.tolist(), 1):
            later = f"more than the {self.times[k - 1]!r} s before it"
            expect(step > 0.0, f"times[{k}]", self.times[k], later)
            near = f"no gap: at most {_GAP:g} times the usual {most / _GAP:.6g} s after the last"
            expect(step <= most, f"times[{k}]", self.times[k], f"{near}, not {step:.6g} s")

    def _check_positions(self) -> None:
        times, position, _ = self._samples
        for k, radius in enumerate(np.linalg.norm(position, axis=1)):
            reach = (
                f"a position above ground and near the Earth, |r| from {EARTH_RADIUS:.12g} to "
                f"{_FARTHEST:g} m, not {radius:.6g} m"
            )
            sound = EARTH_RADIUS <= radius <= _FARTHEST
            expect(sound, f"position[{k}]", self.position[k], reach)
        expected, _ = interpolate(*self._samples, others(len(times), self._points), times)
        missed = np.linalg.norm(expected - position, axis=1)
        k = 1 + int(np.argmax(missed[1:-1]))  # the ends are between no others
        near = (
            f"a position within {_MOST_MISSED:g} m of what those around it give, not "
            f"{missed[k]:.6g} m: it is wrong, samples are too far apart, or velocities have "
            "another unit or frame"
        )
        expect(missed[k] <= _MOST_MISSED, f"position[{k}]", self.position[k], near)
        fastest = int(np.argmax(self._energies()))
        held = "a position and a speed with which the Earth holds the satellite"
        expect(
            self._energies()[fastest] < 0.0, f"position[{fastest}]", self.position[fastest], held
        )


def points(degree: int, velocities: bool) -> int:
    """How many samples a polynomial goes through: with velocities each of them counts twice."""
    return (degree + 2) // 2 if velocities else degree + 1
