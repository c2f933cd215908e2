"""Scenario files: TOML with a comment on every key, presets to start from, and older versions."""

from __future__ import annotations

import os
import tomllib
import warnings
from collections.abc import Iterator, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

import tomlkit

from mgeo_attitude.environment.orbit import ORBITS
from mgeo_attitude.fields.checking import Validated
from mgeo_attitude.fields.quantity import InvalidValue, KeyProblem, declared, known_names

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
            FutureWarning,
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
                FutureWarning,
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


#: The schema of a scenario file for editors, beside it: the output of the command ``schema``.
SCHEMA_FILE = "scenario.schema.json"

_HEADER = f"""\
#:schema ./{SCHEMA_FILE}
# Scenario of mgeo-attitude. A file may also start from a preset and say
# only what differs: preset = {" or ".join(f'"{preset}"' for preset in PRESETS)}
"""


class ScenarioFileError(ValueError):
    """A scenario file, or text, that cannot be read; the message says which and where."""


def read_toml(source: str | os.PathLike[str]) -> tuple[str, Path, dict[str, Any]]:
    """What a file or text is called in messages, its folder and its table.

    See `Scenario.from_toml`.
    """
    if isinstance(source, str) and ("\n" in source or not source.endswith(".toml")):
        hint = "" if "\n" in source else " (a file's name would end in .toml)"
        origin, folder, text = f"TOML text{hint}", Path(), source
    else:
        from mgeo.store.reading import read_text
        from mgeo.validation.entries import FileError

        origin, folder = os.fspath(source), Path(source).parent
        try:
            text = read_text(origin)
        except FileError as error:
            cause = error.__cause__ or error
            raise ScenarioFileError(f"{origin}: not TOML, which is UTF-8: {cause}") from None
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also of a number of thousands of digits
        raise ScenarioFileError(f"{origin}: not TOML: {error}") from None
    if not table:
        raise ScenarioFileError(f'{origin}: empty; the least it can say is preset = "paper"')
    return origin, folder, table


def to_toml(scenario: Validated, table: Mapping[str, Any], notes: Mapping[str, str]) -> str:
    """A scenario's table as a document; `notes` are added below the tables of these keys."""
    head, sections = [_HEADER], []
    for key, value in table.items():
        part, spec = getattr(scenario, key), declared(type(scenario))[key][1]
        names = f" # one of {', '.join(map(repr, spec.kinds.classes))}" if spec.kinds else ""
        if isinstance(value, Mapping):
            sections += ["", f"[{key}] # {spec.doc}", *_lines(value, part, names)]
        elif isinstance(value, list) and isinstance(value[0], Mapping):
            for entry, own in zip(value, part, strict=True):
                sections += ["", f"[[{key}]]", *_lines(entry, own, names)]
        else:
            head += _lines({key: value}, scenario)
        sections += [f"# {notes[key]}"] if key in notes else []
    return "\n".join([*head, *sections, ""])


def _lines(values: Mapping[str, Any], section: Any, names: str = "") -> Iterator[str]:
    """Key, value, and a comment: meaning and range or choices; `names` where it is no field."""
    fields = declared(type(section)) if isinstance(section, Validated) else {}
    for key, value in values.items():
        own = getattr(section, key, None)
        value = own if isinstance(own, datetime) else value  # TOML has them
        comment = names
        if key in fields:
            spec = fields[key][1]
            limits = ", ".join(map(repr, spec.choices)) or spec.range_text()
            comment = f" # {spec.doc}: {limits}" if limits else f" # {spec.doc}"
        if isinstance(value, list) and isinstance(value[0], Mapping):
            rows = (f"  {_inline(row)},\n" for row in value)
            text = f"[{comment}\n{''.join(rows)}]"
        elif isinstance(value, list) and isinstance(value[0], list):  # a row a line
            rows = (f"  {tomlkit.item(row).as_string()},\n" for row in value)
            text = f"[{comment}\n{''.join(rows)}]"
        else:
            text = f"{tomlkit.item(value).as_string()}{comment}"
        yield f"{tomlkit.key(key).as_string()} = {text}"


def _inline(table: Mapping[str, Any]) -> str:
    """A table on one line."""
    line = tomlkit.inline_table()
    line.update(table)
    return line.as_string()
