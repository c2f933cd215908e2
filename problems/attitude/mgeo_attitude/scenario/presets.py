"""Scenario files to start from, and tables that say what differs from one of them."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mgeo_attitude.environment.orbit import ORBITS
from mgeo_attitude.fields import InvalidValue, known_names

Table = dict[str, Any]

#: Names of the presets; each is a file of this folder.
PRESETS = ("paper", "cubesat_1u", "cubesat_6u", "cubesat_6u_full", "microsatellite")


def on_preset(table: Mapping[str, Any]) -> Table:
    """The table over the preset that it names, if it does, key by key; see `Scenario.from_dict`."""
    overrides = dict(table)
    if "preset" not in overrides:
        return overrides
    preset = overrides.pop("preset")
    if not isinstance(preset, str) or preset not in PRESETS:
        raise InvalidValue("preset", preset, f"unknown preset{known_names(preset, PRESETS)}")
    file = Path(__file__).with_name(f"{preset}.toml")
    return overridden(on_preset(tomllib.loads(file.read_text(encoding="utf-8"))), overrides)


def overridden(base: Table, table: Mapping[str, Any]) -> Table:
    """A complete table with what another says, key by key."""
    overrides = dict(table)
    if _kind_of_orbit(overrides) not in (None, _kind_of_orbit(base)):
        base = {key: base[key] for key in base if key != "orbit"}  # their kinds share no key
    sensors = overrides.get("sensors")
    if isinstance(sensors, list | tuple):
        overrides["sensors"] = [_on_sensor(entry, base["sensors"]) for entry in sensors]
    return _merged(base, overrides)


def _kind_of_orbit(table: Table) -> type | None:
    """The class of the orbit that a table gives; None where it does not say."""
    orbit = table.get("orbit")
    name = ORBITS.named(orbit) if isinstance(orbit, Mapping) else None
    return ORBITS.classes.get(name) if isinstance(name, str) else None


def _on_sensor(table: Any, preset: list[Table]) -> Any:
    """A sensor over the preset's one of its name and kind, or else the only one of its kind."""
    if not isinstance(table, Mapping):
        return table
    name, kind = table.get("name"), table.get("kind")
    same = [one for one in preset if one["name"] == name and kind in (None, one["kind"])]
    same = same or [one for one in preset if one["kind"] == kind]
    return {**same[0], **table} if len(same) == 1 else table


def _merged(base: Table, overrides: Mapping[str, Any]) -> Table:
    merged = dict(base)
    for key, value in overrides.items():
        nested = isinstance(value, Mapping) and isinstance(merged.get(key), Mapping)
        merged[key] = _merged(merged[key], value) if nested else value
    return merged
