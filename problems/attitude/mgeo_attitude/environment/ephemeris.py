"""An orbit that somebody else has computed: positions at instants, interpolated in between."""

from __future__ import annotations

import itertools
from datetime import datetime
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, ClassVar, Self

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import EARTH_MU, EARTH_RADIUS
from mgeo_attitude.environment.kepler import orbital_period
from mgeo_attitude.environment.times import elapsed, utc_text
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import expect
from mgeo_attitude.settings.types import Instant, Unit, Vector

if TYPE_CHECKING:
    from mgeo_attitude.environment.arc import Arc

#: Degree of the polynomials if nobody says one: through 8 positions, or 4 with velocities.
DEFAULT_DEGREE = 7
MOST_DEGREE = 15
#: Instants this near [s] are the same: files round theirs, mostly to a microsecond.
SAME_INSTANT = 2e-6

_FARTHEST = 1e9  # m; the Earth's gravity rules as far as 9.2e8 m (its sphere of influence)
_MOST_MISSED = 1000.0  # m, as much as the best element sets are off


@dataclass(frozen=True, kw_only=True)
class EphemerisOrbit(Settings):
    """Samples of a position in GCRS: Hermite's polynomials with velocities, Lagrange's without.

    Two samples of the same time are before and after a jump: no polynomial goes through both.

    Raises
    ------
    InvalidValue
        For times out of order, too few samples, unequal numbers of them, a
        position below ground or beyond the Earth's reach, a satellite that the Earth does not hold,
        or a sample that those around it miss by more than 1 km: it is wrong, they are too far
        apart, or the velocities are not those of the positions.

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
    """where the samples come from"""
    epoch: Instant
    """instant from which the times count, with its UTC offset"""
    degree: int = Field(default=DEFAULT_DEGREE, ge=1, le=MOST_DEGREE)
    """degree of the polynomials"""
    times: Annotated[tuple[float, ...], Unit("s")]
    """SI seconds after the epoch, in order; the same twice is a jump"""
    position: Annotated[tuple[Vector, ...], Unit("m")]
    """positions, GCRS"""
    velocity: Annotated[tuple[Vector, ...], Unit("m/s")] = ()
    """velocities, GCRS, if known"""

    def __post_init__(self) -> None:
        n, need = len(self.times), max(3, points(self.degree, bool(self.velocity)))
        enough = f"at least {need} for degree = {self.degree}; fewer allow a lower degree"
        expect(n >= need, "times", f"{n} samples", enough)
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
        return self._at(times + elapsed(self.epoch, epoch))

    def for_run(self, epoch: datetime, duration: float) -> Self:
        """Itself, or an InvalidValue if its samples have a gap in a run, or do not reach its ends.

        A gap is where the error of interpolation is about 1 km or more.
        """
        start = elapsed(self.epoch, epoch)
        first, last = self.times[0], self.times[-1]
        inside = first <= start + SAME_INSTANT and start + duration <= last + SAME_INSTANT
        run = (
            f"samples for the whole run, from {start:.12g} to {start + duration:.12g} s after "
            f"orbit.epoch = {self.epoch.isoformat()}"
        )
        expect(inside, "times", f"{first:.12g} to {last:.12g}", run)
        for arc in self._arcs:
            needed = (arc.times[1:] > start) & (arc.times[:-1] < start + duration)
            for k in np.flatnonzero(needed & (arc.error > _MOST_MISSED))[:1]:
                begin, end = arc.times[k : k + 2].tolist()
                span = f"{utc_text(self.epoch, begin)} to {utc_text(self.epoch, end)}"
                between = (
                    f"samples in this gap of {end - begin:.6g} s, in which polynomials of degree "
                    f"{self.degree} are off by about {arc.error[k]:.2g} m (at most "
                    f"{_MOST_MISSED:g} m)"
                )
                expect(False, "times", span, between)
        return self

    def later(self, time: float) -> Self:
        """Itself: it has an epoch of its own."""
        return self

    @cached_property
    def _arcs(self) -> list[Arc]:
        """Between two samples of the same time; of one sample alone there is none."""
        from mgeo_attitude.environment.arc import Arc

        count = points(self.degree, bool(self.velocity))
        times, position = np.array(self.times), np.array(self.position)
        velocity = np.array(self.velocity) if self.velocity else None
        ends = [0, *(1 + np.flatnonzero(np.diff(times) == 0.0)).tolist(), len(times)]
        slices = [slice(a, b) for a, b in itertools.pairwise(ends) if b - a > 1]
        return [
            Arc(
                times[part],
                position[part],
                None if velocity is None else velocity[part],
                min(count, part.stop - part.start),
            )
            for part in slices
        ]

    def _at(self, at: Floats) -> tuple[Floats, Floats]:
        position, velocity = np.empty((len(at), 3)), np.empty((len(at), 3))
        starts = [arc.times[0] for arc in self._arcs[1:]]
        which = np.searchsorted(starts, at, side="right")
        for k, arc in enumerate(self._arcs):
            own = which == k
            position[own], velocity[own] = arc.at(at[own])
        return position, velocity

    def _energies(self) -> Floats:
        """Of the samples, kinetic and potential [m²/s²], shape (n,)."""
        position, velocity = self._at(np.array(self.times))
        kinetic = 0.5 * np.einsum("ni,ni->n", velocity, velocity)
        return np.asarray(kinetic - EARTH_MU / np.linalg.norm(position, axis=1))

    def _check_times(self) -> None:
        for k, step in enumerate(np.diff(self.times).tolist(), 1):
            later = f"more than the {self.times[k - 1]!r} s before it"
            jump = step == 0.0 and self.times[k] not in self.times[k + 1 : k + 2]
            expect(step > 0.0 or jump, f"times[{k}]", self.times[k], later)

    def _check_positions(self) -> None:
        for k, radius in enumerate(np.linalg.norm(self.position, axis=1)):
            reach = (
                f"a position above ground and near the Earth, |r| from {EARTH_RADIUS:.12g} to "
                f"{_FARTHEST:g} m, not {radius:.6g} m"
            )
            sound = EARTH_RADIUS <= radius <= _FARTHEST
            expect(sound, f"position[{k}]", self.position[k], reach)
        for arc in self._arcs:
            missed = arc.missed(_MOST_MISSED)
            worst = int(np.argmax(missed))
            near = (
                f"a position within {_MOST_MISSED:g} m of what those around it give, not "
                f"{missed[worst]:.6g} m: it is wrong, samples are too far apart, or velocities "
                "have another unit or frame"
            )
            k = self.times.index(arc.times[worst])
            expect(missed[worst] <= _MOST_MISSED, f"position[{k}]", self.position[k], near)
        fastest = int(np.argmax(self._energies()))
        held = "a position and a speed with which the Earth holds the satellite"
        expect(
            self._energies()[fastest] < 0.0, f"position[{fastest}]", self.position[fastest], held
        )


def points(degree: int, velocities: bool) -> int:
    """How many samples a polynomial goes through: with velocities each of them counts twice."""
    return (degree + 2) // 2 if velocities else degree + 1
