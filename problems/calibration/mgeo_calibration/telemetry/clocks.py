"""Times and positions that do not fit field and Sun, seen without any attitude.

How strong the field is and how far it is from the Sun do not depend on the attitude, but on time
and place.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import DAY
from mgeo_attitude.environment.environment import sun_and_field
from mgeo_attitude.environment.frames import to_gcrs
from mgeo_attitude.environment.sun_moon import sun_direction
from mgeo_attitude.environment.times import instants
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.errors import sigma_of
from mgeo_attitude.sensors.vector_sensors import Magnetometer, SunSensor
from mgeo_attitude.sensors.world import FIELD_UNIT_NT

from mgeo_calibration.telemetry.telemetry import Telemetry

#: Samples that are looked at, at most.
_SAMPLES = 200
_FEWEST = 12
#: A cause leaves this share of the misfit, and what fits is off by no more 1-sigmas than that.
_BETTER, _WELL = 0.25, 3.0
#: What a model of the Earth's field leaves of it, beside what currents above add.
_FIELD_MODEL = 0.003
_LINEARIZED = 4  # times, for the magnetometer's bias
_NORMAL = 0.6745  # median magnitude of a normal number
#: Units that times may be in [s].
_UNITS = {"milliseconds": 1e-3, "microseconds": 1e-6, "minutes": 60.0, "hours": 3600.0, "days": DAY}
#: What ground systems count from, and in what [s].
_CALENDARS = {
    "days of Excel": (datetime(1899, 12, 30, tzinfo=UTC), DAY),
    "modified Julian dates": (datetime(1858, 11, 17, tzinfo=UTC), DAY),
    "Julian dates": (datetime(1858, 11, 17, tzinfo=UTC), DAY),
    "days since 1970": (datetime(1970, 1, 1, tzinfo=UTC), DAY),
    "days since 2000": (datetime(2000, 1, 1, 12, tzinfo=UTC), DAY),
    "Unix seconds": (datetime(1970, 1, 1, tzinfo=UTC), 1.0),
    "Unix milliseconds": (datetime(1970, 1, 1, tzinfo=UTC), 1e-3),
    "GPS seconds": (datetime(1980, 1, 6, tzinfo=UTC), 1.0),
    "seconds since J2000": (datetime(2000, 1, 1, 12, tzinfo=UTC), 1.0),
}
_JULIAN = 2_400_000.5  # of the modified ones
_YEARS = 3.0 * 365.25 * DAY  # about the epoch in which telemetry is
_HOUR = 3600.0
_STEADY = 5e-3  # by how much an orbit's plane may turn [rad]


@dataclass(frozen=True, eq=False)
class Seen:
    """m samples of a magnetometer, with a Sun sensor's where it reported.

    Attributes
    ----------
    times : array, shape (m,)
    field : array, shape (m, 3)
        [nT]
    sun : array, shape (m, 3)
        Of unit length, or NaN.
    position : array, shape (m, 3), optional
    noise, bias : float
        What is believed of the magnetometer, per axis [nT].
    share : float
        By how much of its length a reading is off beside.
    angle : float
        By how much what is believed of both moves the angle between them [rad].
    """

    times: Floats
    field: Floats
    sun: Floats
    position: Floats | None
    noise: float
    bias: float
    share: float
    angle: float

    def misfit(self, toward: Floats, around: Floats) -> tuple[float, float]:
        """Medians of what is left of lengths, and of angles, over the 1-sigmas that are believed.

        Of the Sun's direction and the field [nT] that should be there, both of shape (m, 3). The
        magnetometer's bias b is that with which |y - b|² is nearest to |B|² (R. Alonso, M. D.
        Shuster, TWOSTEP, Journal of the Astronautical Sciences 50 (2002) 433-451), and believed no
        more than it is: any smooth course of |B| fits one that is large enough.
        """
        size = np.linalg.norm(around, axis=1)
        weight = 0.5 / (size * np.hypot(self.noise, self.share * size))
        bias = np.zeros(3)
        for _ in range(_LINEARIZED):
            unbiased = self.field - bias
            more = weight * ((unbiased**2).sum(axis=1) - size**2)
            slopes = np.vstack([2.0 * weight[:, None] * unbiased, np.eye(3) / self.bias])
            bias += np.linalg.lstsq(slopes, np.append(more, -bias / self.bias), rcond=None)[0]
        unbiased = self.field - bias
        length = np.linalg.norm(unbiased, axis=1)
        lengths = float(np.median(weight * np.abs(length**2 - size**2))) / _NORMAL
        cosine = (self.sun * unbiased).sum(axis=1) / length
        should = (toward * around).sum(axis=1) / size
        both = np.isfinite(cosine)
        if both.sum() < _FEWEST:
            return lengths, 0.0
        off = float(np.median(np.abs(cosine - should)[both])) / _NORMAL
        return lengths, off / float(np.hypot(self.angle, self.noise / np.median(size)))


def clock_causes(scenario: Scenario, telemetry: Telemetry) -> Iterator[str]:
    """In words: first what is seen of times alone, then what fits field and Sun far better."""
    if words := _calendar(scenario, telemetry.times):
        yield words
        return
    if telemetry.position is not None and _turns_with_the_earth(scenario, telemetry):
        yield "position turns with the Earth, as in ITRF (ECEF): expected GCRS"
        return
    seen = _seen(scenario, telemetry)
    if seen is None:
        return
    (now,) = _misfits(scenario, seen, seen.times[None])
    if max(now) < _WELL:
        return
    found = _candidates(scenario, seen)
    best = min(found, key=lambda words: sum(found[words]))
    if max(found[best]) < _WELL and sum(found[best]) < _BETTER * sum(now):
        yield best


def _candidates(scenario: Scenario, seen: Seen) -> dict[str, tuple[float, float]]:
    """By words, what is left if they are so."""
    t, found = seen.times[None], {}
    for unit, factor in _UNITS.items():
        (found[f"times are in {unit}, not seconds"],) = _misfits(scenario, seen, factor * t)
    zones = 0.5 * np.array([half_hours for half_hours in range(-28, 29) if half_hours])
    left = _misfits(scenario, seen, t - _HOUR * zones[:, None])
    for hours, each in zip(zones.tolist(), left, strict=True):
        side = "ahead of" if hours > 0.0 else "behind"
        found[f"times are {abs(hours):g} h {side} UTC: local time?"] = each
    if seen.position is None:
        behind = 0.0  # by how much the satellite is, if that is all that is wrong [s]
        for offs in (np.arange(-2760.0, 2761.0, 120.0), np.arange(-105.0, 106.0, 15.0)):
            tried = behind + offs
            left = _misfits(scenario, seen, np.repeat(t, len(tried), axis=0), tried)
            each, behind = min(zip(left, tried.tolist(), strict=True), key=lambda one: sum(one[0]))
        words = (
            f"the satellite is about {abs(behind):.0f} s {'behind' if behind > 0.0 else 'ahead of'}"
            " its orbit along the track: are elements and epoch of the same time?"
        )
        found[words] = each
    return found


def _misfits(
    scenario: Scenario, seen: Seen, times: Floats, behind: Floats | None = None
) -> list[tuple[float, float]]:
    """Of samples at other times, shape (k, m), of a satellite behind its orbit, shape (k,) [s].

    Infinite where no environment is known.
    """
    position = None if seen.position is None else np.broadcast_to(seen.position, (*times.shape, 3))
    try:
        if position is None:
            flown = times if behind is None else times - behind[:, None]
            position = _each(lambda at: scenario.orbit.propagate(scenario.epoch, at)[0], flown)
        toward, around = _sun_and_field(scenario, times, position)
    except (ValueError, ArithmeticError):
        return [(np.inf, np.inf)] * len(times)
    return [seen.misfit(*one) for one in zip(toward, around, strict=True)]


def _sun_and_field(scenario: Scenario, times: Floats, position: Floats) -> tuple[Floats, Floats]:
    """As of an `Environment`, of any times (k, m) and places (k, m, 3), both (k, m, 3).

    All at once: the field's model takes as long to begin as for 1000 places.
    """
    order = np.argsort(times, axis=None)
    sun, field = np.empty((2, times.size, 3))
    sun[order], field[order] = sun_and_field(
        scenario.epoch, times.ravel()[order], position.reshape(-1, 3)[order]
    )
    return sun_direction(position, sun.reshape(position.shape)), field.reshape(position.shape)


def _each(function: Callable[[Floats], Floats], times: Floats) -> Floats:
    """A function of increasing times, at times in any order."""
    at, which = np.unique(times, return_inverse=True)
    return function(at)[which.reshape(times.shape)]


def _seen(scenario: Scenario, telemetry: Telemetry) -> Seen | None:
    """Samples of the first magnetometer, with those of the first Sun sensor."""
    there = [sensor for sensor in scenario.sensors if sensor.name in telemetry.sensors]
    mags = [sensor for sensor in there if isinstance(sensor, Magnetometer)]
    suns = [sensor for sensor in there if isinstance(sensor, SunSensor)]
    if not mags:
        return None
    field = telemetry.sensors[mags[0].name]
    sun = telemetry.sensors[suns[0].name] if suns else np.full_like(field, np.nan)
    seen = np.isfinite(field[:, 0])
    if (seen & np.isfinite(sun[:, 0])).sum() > _SAMPLES // 2:
        seen &= np.isfinite(sun[:, 0])
    k = np.flatnonzero(seen)
    if len(k) < _FEWEST:
        return None
    k = k[np.unique(np.linspace(0, len(k) - 1, _SAMPLES).astype(int))]
    with np.errstate(invalid="ignore"):
        direction = sun[k] / np.linalg.norm(sun[k], axis=1)[:, None]
    believed = _believed(mags[0])
    across = [believed.get("misalignment", 0.0), believed.get("nonorthogonality", 0.0)]
    for sensor in suns[:1]:
        of = _believed(sensor)
        across += [max(sensor.noise()), of.get("misalignment", 0.0), of.get("bias", 0.0)]
    return Seen(
        telemetry.times[k],
        field[k],
        direction,
        telemetry.positions(telemetry.times[k]),
        noise=float(np.hypot(FIELD_UNIT_NT * max(mags[0].noise()), scenario.world.field_error_nt)),
        bias=FIELD_UNIT_NT * believed["bias"],
        share=math.hypot(_FIELD_MODEL, believed.get("scale_factor", 0.0)),
        angle=math.hypot(*across),
    )


def _believed(sensor: Sensor) -> dict[str, float]:
    """Initial 1-sigmas of its states, of the axis of which least is known."""
    return {name: float(np.max(sigma_of(value))) for name, value in sensor.states().items()}


def _calendar(scenario: Scenario, times: Floats) -> str | None:
    """Times that are those of the epoch if they are counted from elsewhere."""
    if len(times) < 2:
        return None
    step = float(np.median(np.diff(times)))
    for words, (start, unit) in _CALENDARS.items():
        since = times[0] - (_JULIAN if words == "Julian dates" else 0.0)
        off = since * unit - (scenario.epoch - start).total_seconds()
        right = abs(off) < _YEARS and 1e-4 < step * unit < 3600.0
        if right and (unit == 1.0 or not 1e-3 < step < 3600.0):
            return f"times are {words}: expected seconds since the epoch, or ISO 8601"
    return None


def _turns_with_the_earth(scenario: Scenario, telemetry: Telemetry) -> bool:
    """Whether the orbit's plane stays far better once positions are taken to be in ITRF."""
    assert telemetry.position is not None
    k = np.flatnonzero(np.isfinite(telemetry.position[:, 0]))
    if len(k) < _FEWEST:
        return False
    k = k[np.unique(np.linspace(0, len(k) - 1, _FEWEST).astype(int))]
    position, at = telemetry.position[k], instants(scenario.epoch, telemetry.times[k])
    given, turned = (_tilt(each) for each in (position, to_gcrs("ITRF", at, position, None)[0]))
    return bool(given > _STEADY and turned < _BETTER * given)


def _tilt(position: Floats) -> float:
    """By how much the plane of an orbit turns [rad]."""
    normal = np.cross(position[:-1], position[1:])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return float(np.linalg.norm(normal - normal[0], axis=1).max())
