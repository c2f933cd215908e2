"""What is told of a scenario that nothing refuses: what looks like a slip, and where the linear
covariance can be believed.
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import timedelta
from typing import TYPE_CHECKING, Any

import numpy as np

from mgeo_attitude.environment.constants import EARTH_RADIUS
from mgeo_attitude.environment.element_set import MAX_AGE, ElementSet
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.vector_sensors import Magnetometer
from mgeo_attitude.settings.base import Settings, annotation_of, declared
from mgeo_attitude.settings.types import Unit, Usual

if TYPE_CHECKING:
    from mgeo_attitude.scenario.scenario import Scenario

#: Where IGRF, a field without currents outside the Earth, is one: geocentric distance in Earth
#: radii above which the ring current's field is no longer small beside it, and altitude [m] below
#: which nothing orbits.
_HIGHEST, _LOWEST = 3.0, 100e3
#: Samples of the orbit at which that is looked at.
_SAMPLES = 200


class Implausible(UserWarning):
    """A value that looks like a slip: another unit, or what the model is not made for."""


def implausible(scenario: Scenario) -> tuple[str, ...]:
    """What looks like a slip, each in a line that names the key; empty if nothing does."""
    return (*_unusual(scenario), *_out_of_range(scenario), *_too_old(scenario))


def _unusual(settings: Any, place: str = "") -> Iterator[str]:
    """Yield a line for each number outside its `Usual` range; zero leaves something out."""
    for name in declared(type(settings)):
        value, key = getattr(settings, name), f"{place}{name}"
        values = value if isinstance(value, tuple) else (value,)
        usual = annotation_of(type(settings), name, Usual)
        unit = annotation_of(type(settings), name, Unit)
        text = f" {unit.text}" if unit else ""
        for i, each in enumerate(values):
            if isinstance(each, Settings):
                yield from _unusual(each, f"{key}[{i}]." if values is value else f"{key}.")
            elif usual and each and not usual.low <= each <= usual.high:
                expected = f"usual is {usual.low:g} to {usual.high:g}{text}"
                yield f"{key} = {each:g}{text}: {expected}; is it of another unit?"
                break


def _out_of_range(scenario: Scenario) -> Iterator[str]:
    if not any(isinstance(sensor, Magnetometer) for sensor in scenario.sensors):
        return
    times = np.linspace(0.0, scenario.latest_end, _SAMPLES)
    distance = np.linalg.norm(scenario.orbit.propagate(scenario.epoch, times)[0], axis=1)
    if (most := float(distance.max()) / EARTH_RADIUS) > _HIGHEST:
        yield (
            f"orbit: {most:.1f} Earth radii from the Earth's center: above {_HIGHEST:g} the field "
            "is not IGRF's, which knows of no currents outside the Earth"
        )
    if (least := float(distance.min()) - EARTH_RADIUS) < _LOWEST:
        yield f"orbit: down to {1e-3 * least:.0f} km: nothing orbits below {1e-3 * _LOWEST:g} km"


def _too_old(scenario: Scenario) -> Iterator[str]:
    orbit = scenario.orbit
    if not isinstance(orbit, ElementSet):
        return
    age = scenario.epoch + timedelta(seconds=scenario.latest_end) - orbit.instant
    if age > MAX_AGE:
        yield (
            f"orbit: at the end of the run the element set is {age / timedelta(days=1):.1f} days "
            f"old, and tens of kilometers off: it is good for {MAX_AGE.days}"
        )


class OutsideValidity(UserWarning):
    """A scenario's initial errors are larger than those for which the filter was found true."""


#: Largest initial 1-sigma per axis in the map of docs/consistency.md up to which the NEES of the
#: shipped estimator is within its 99 % bounds for both presets.
MAX_ATTITUDE_DEG = 20.0
MAX_MISALIGNMENT_DEG = 1.0
MAX_GYRO_BIAS_DEG_S = 0.01

#: With photodiodes, of which few see the Sun at a time: from 10 deg `cubesat_1u` has a NEES of 1.2,
#: from 5 deg of 1.04.
MAX_ATTITUDE_OF_FACES_DEG = 5.0

#: Of the orbit, along which the field's derivative changes. In 50 flights of Basilisk, with IGRF
#: where the satellite is, NEES is 1.07 with an error of 30 km along track, within its 99 % bounds;
#: 1.14 with one of 50 is not.
MAX_ORBIT_ERROR_M = 30_000.0


def examined(scenario: Scenario) -> list[tuple[str, float, float]]:
    """Initial uncertainties by key, each with the largest at which the map has found it true."""
    faces = any(isinstance(sensor, Photodiode) for sensor in scenario.sensors)
    attitude = MAX_ATTITUDE_OF_FACES_DEG if faces else MAX_ATTITUDE_DEG
    gyro, key = scenario.gyro, "initial_misalignment_deg"
    limits = [
        ("initial.attitude_deg", scenario.initial.attitude_deg, attitude),
        ("gyro.initial_bias_deg_s", gyro.initial_bias_deg_s, MAX_GYRO_BIAS_DEG_S),
        (f"gyro.{key}", gyro.initial_misalignment_deg, MAX_MISALIGNMENT_DEG),
    ]
    if scenario.world.has_orbit_error and scenario.needs_field:
        along = max(scenario.world.orbit_error_m)
        limits.append(("world.orbit_error_m", along, MAX_ORBIT_ERROR_M))
    return limits + [
        (f"sensors[{index}].{key}", getattr(sensor, key, 0.0), MAX_MISALIGNMENT_DEG)
        for index, sensor in enumerate(scenario.sensors)
        if not isinstance(sensor, Photodiode)  # its readings are linear in the tilts of its normal
    ]


def validity(scenario: Scenario) -> tuple[str, ...]:
    """Why the linear covariance may promise more than a filter achieves; empty if it need not.

    Compares initial uncertainties with the map of docs/consistency.md, which sweeps one at a time
    from the presets. A scenario within it is no proof; `simulate` is.

    Parameters
    ----------
    scenario : Scenario

    Examples
    --------
    >>> from mgeo_attitude import Scenario, validity
    >>> wild = Scenario.from_dict({"preset": "paper", "initial": {"attitude_deg": 60.0}})
    >>> validity(Scenario.paper()), len(validity(wild))
    ((), 1)
    """
    if scenario.prior is not None:  # a calibration is better than all of these
        return ()
    return tuple(
        f"{key} = {value:g}: the linear covariance was found true up to {limit:g}"
        for key, value, limit in examined(scenario)
        if value > limit
    )
