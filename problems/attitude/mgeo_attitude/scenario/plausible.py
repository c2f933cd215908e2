"""What a scenario says that hardly any satellite has: told, not refused."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import is_dataclass
from datetime import timedelta
from typing import Any

import numpy as np

from mgeo_attitude.environment.constants import EARTH_RADIUS
from mgeo_attitude.environment.element_set import MAX_AGE, ElementSet
from mgeo_attitude.fields import declared
from mgeo_attitude.sensors import Magnetometer

#: Where IGRF, a field without currents outside the Earth, is one: geocentric distance in Earth
#: radii above which the ring current's field is no longer small beside it, and altitude [m] below
#: which nothing orbits.
_HIGHEST, _LOWEST = 3.0, 100e3
#: Samples of the orbit at which that is looked at.
_SAMPLES = 200


class Implausible(UserWarning):
    """A value that looks like a slip: another unit, or what the model is not made for."""


def implausible(scenario: Any) -> tuple[str, ...]:
    """What looks like a slip, each in a line that names the key; empty if nothing does."""
    return (*_unusual(scenario), *_out_of_range(scenario), *_too_old(scenario))


def _unusual(section: Any, place: str = "") -> Iterator[str]:
    """Numbers outside the range that their `Quantity` calls usual; zero is what is left out."""
    for name, (_, spec) in declared(type(section)).items():
        value, key = getattr(section, name), f"{place}{name}"
        if is_dataclass(value):
            yield from _unusual(value, f"{key}.")
        elif isinstance(value, tuple) and any(map(is_dataclass, value)):
            for i, each in enumerate(value):
                yield from _unusual(each, f"{key}[{i}].")
        elif spec.usual and value is not None:
            low, high = spec.usual
            numbers = value if isinstance(value, tuple) else (value,)
            for number in numbers:
                if number and not low <= number <= high:
                    unit = f" {spec.unit}" if spec.unit else ""
                    usual = f"usual is {low:g} to {high:g}{unit}"
                    yield f"{key} = {number:g}{unit}: {usual}; is it of another unit?"
                    break


def _out_of_range(scenario: Any) -> Iterator[str]:
    if not any(isinstance(sensor, Magnetometer) for sensor in scenario.sensors):
        return
    times = np.linspace(0.0, _last(scenario), _SAMPLES)
    distance = np.linalg.norm(scenario.orbit.propagate(scenario.epoch, times)[0], axis=1)
    if (most := float(distance.max()) / EARTH_RADIUS) > _HIGHEST:
        yield (
            f"orbit: {most:.1f} Earth radii from the Earth's center: above {_HIGHEST:g} the field "
            "is not IGRF's, which knows of no currents outside the Earth"
        )
    if (least := float(distance.min()) - EARTH_RADIUS) < _LOWEST:
        yield f"orbit: down to {1e-3 * least:.0f} km: nothing orbits below {1e-3 * _LOWEST:g} km"


def _too_old(scenario: Any) -> Iterator[str]:
    orbit = scenario.orbit
    if not isinstance(orbit, ElementSet):
        return
    age = scenario.epoch + timedelta(seconds=_last(scenario)) - orbit.instant
    if age > MAX_AGE:
        yield (
            f"orbit: at the end of the run the element set is {age / timedelta(days=1):.1f} days "
            f"old, and tens of kilometers off: it is good for {MAX_AGE.days}"
        )


def _last(scenario: Any) -> float:
    """When the last of its runs ends at the latest [s]."""
    return float(scenario.duration + (scenario.maneuvers.latest_start or 0.0))
