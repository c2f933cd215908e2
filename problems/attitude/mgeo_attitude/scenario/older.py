"""Scenario tables of older versions, as this one takes them."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

from mgeo_attitude.fields import KeyProblem

#: Errors that each sensor had for itself, and what is said of them.
_OF_SENSORS = {
    "albedo": ("albedo", "albedo_correlation_time"),
    "field_error": ("field_error_nt", "field_error_correlation_time"),
    "orbit_error": ("orbit_error_m", "orbit_error_correlation_time"),
}
#: Keys of sensors that have other names now.
_NOW = {"field_of_view_deg": "half_angle_deg"}
_KEYS = [key for keys in _OF_SENSORS.values() for key in keys]


def updated(table: Mapping[str, Any]) -> dict[str, Any]:
    """A table of today's keys, in which errors of field, orbit and light are the world's.

    A suite in which one sensor had each is the same satellite. What several had alike is now one
    error; a Sun sensor without albedo beside one with it does not see it.

    Raises
    ------
    KeyProblem
        For sensors that had it otherwise.
    """
    sensors = table.get("sensors")
    if not isinstance(sensors, list | tuple):
        return dict(table)
    table = {**table, "sensors": [_renamed(each) for each in sensors]}
    sensors = table["sensors"]
    world: dict[str, Any] = {}
    lit = any(isinstance(each, Mapping) and each.get("albedo") for each in sensors)
    kept = [_without(world, f"sensors[{i}]", each, lit) for i, each in enumerate(sensors)]
    if not world:
        return dict(table)
    if any(world.get(keys[0]) for keys in _OF_SENSORS.values()):
        moved = ", ".join(key for key in world if key in _KEYS)
        warnings.warn(
            f"{moved} of sensors: of the world, which all share, and now in [world]; gone in 0.4",
            DeprecationWarning,
            stacklevel=3,
        )
    if "orbit_error_m" in world:
        world |= {"orbit_error_m": 3 * [world["orbit_error_m"]], "orbit_error_axes": "inertial"}
    given = table.get("world", {})
    both = {**world, **given} if isinstance(given, Mapping) else given
    return {**table, "sensors": kept, "world": both}


def _renamed(sensor: Any) -> Any:
    """A sensor's table with `_NOW` in place of older keys."""
    if not isinstance(sensor, Mapping):
        return sensor
    for key in _NOW.keys() & sensor.keys():
        if sensor[key] != 180.0:  # which sees everywhere: nobody takes it for a full angle
            warnings.warn(
                f"{key} of sensors is half of it, and now {_NOW[key]}; gone in 0.4",
                DeprecationWarning,
                stacklevel=4,
            )
    return {_NOW.get(key, key): value for key, value in sensor.items()}


def _without(world: dict[str, Any], place: str, sensor: Any, lit: bool) -> Any:
    """A sensor's table without what has become the `world`'s."""
    if not isinstance(sensor, Mapping):
        return sensor
    own = {key: sensor[key] for key in _KEYS if key in sensor}
    rest = {key: value for key, value in sensor.items() if key not in own}
    if lit and own.get("albedo") == 0.0:
        rest["sees_albedo"] = False
        own = {key: own[key] for key in own if key not in _OF_SENSORS["albedo"]}
    for key, value in own.items():
        if world.setdefault(key, value) != value:
            alike = f"is the world's, the same for all sensors: give {key} in [world]"
            raise KeyProblem(f"{place}.{key}", value, alike)
    names = sensor.get("considered")
    if isinstance(names, list | tuple) and (shared := [n for n in names if n in _OF_SENSORS]):
        world["considered"] = list(dict.fromkeys([*world.get("considered", ()), *shared]))
        rest["considered"] = [name for name in names if name not in shared]
    return rest
