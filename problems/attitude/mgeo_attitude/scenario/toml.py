"""Scenario files in TOML: reading, merging with presets, and writing with comments."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterator, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

import tomlkit

from mgeo_attitude.environment.orbit import ORBITS
from mgeo_attitude.settings.base import Settings, build_schema
from mgeo_attitude.settings.errors import InvalidValue, format_known_names
from mgeo_attitude.settings.schema_description import describe_schema

Table = dict[str, Any]

#: Descriptions of the presets by name, each a file in this folder.
PRESETS: Mapping[str, str] = {
    "paper": "satellite of the published paper; the default",
    "cubesat_1u": "1U cubesat with magnetorquers as its only actuators",
    "cubesat_6u": "6U cubesat with small instruments",
    "cubesat_6u_full": "cubesat_6u with further instrument and model errors",
    "microsatellite": "110 kg satellite with star trackers and wheels",
}


def merge_preset(table: Mapping[str, Any]) -> Table:
    """Fill in the missing keys of a scenario table from its preset.

    A table without the key ``preset`` is copied unchanged. See `Scenario.from_dict` for the rules.

    Raises
    ------
    InvalidValue
        If the preset does not exist.
    """
    overrides = dict(table)
    if "preset" not in overrides:
        return overrides
    preset = overrides.pop("preset")
    if not isinstance(preset, str) or preset not in PRESETS:
        raise InvalidValue("preset", preset, f"unknown preset{format_known_names(preset, PRESETS)}")
    file = Path(__file__).with_name(f"{preset}.toml")
    return merge_table(merge_preset(tomllib.loads(file.read_text(encoding="utf-8"))), overrides)


def merge_table(base: Table, overrides: Mapping[str, Any]) -> Table:
    """Return a copy of a scenario table, updated recursively with `overrides`.

    An orbit of another class replaces the whole orbit, and a list of sensors the whole list.
    """
    overrides = dict(overrides)
    if _find_orbit_class(overrides) not in (None, _find_orbit_class(base)):
        base = {key: base[key] for key in base if key != "orbit"}  # Orbit classes share no keys.
    sensors = overrides.get("sensors")
    if isinstance(sensors, list | tuple):
        overrides["sensors"] = [_merge_sensor(entry, base["sensors"]) for entry in sensors]
    return _merge(base, overrides)


def _find_orbit_class(table: Table) -> type | None:
    """Return the class of the orbit in a scenario table, or None if it is not determined."""
    orbit = table.get("orbit")
    name = ORBITS.get_class_name(orbit) if isinstance(orbit, Mapping) else None
    return ORBITS.classes.get(name) if isinstance(name, str) else None


def _merge_sensor(table: Any, preset: list[Table]) -> Any:
    """Fill in the missing keys of a sensor table from a sensor of the preset.

    This is the sensor of the same name and kind or, failing that, the only sensor of the same kind.
    """
    if not isinstance(table, Mapping):
        return table
    name, kind = table.get("name"), table.get("kind")
    matches = [each for each in preset if each["name"] == name and kind in (None, each["kind"])]
    matches = matches or [each for each in preset if each["kind"] == kind]
    return {**matches[0], **table} if len(matches) == 1 else table


def _merge(base: Table, overrides: Mapping[str, Any]) -> Table:
    merged = dict(base)
    for key, value in overrides.items():
        nested = isinstance(value, Mapping) and isinstance(merged.get(key), Mapping)
        merged[key] = _merge(merged[key], value) if nested else value
    return merged


#: Name of the JSON Schema in the folder of a scenario file, as written by the command ``schema``.
SCHEMA_FILE = "scenario.schema.json"

_HEADER = f"""\
#:schema ./{SCHEMA_FILE}
# Scenario of mgeo-attitude. A file may also start from a preset and contain
# only the keys that differ: preset = {" or ".join(f'"{preset}"' for preset in PRESETS)}
"""


class ScenarioFileError(ValueError):
    """Error for a scenario file or TOML text that cannot be read.

    The message names the file and the key or line.
    """


def read_toml(source: str | os.PathLike[str]) -> tuple[str, Path, Table]:
    """Parse a TOML file, or a string that contains TOML.

    Return the name of the source for error messages, the folder of the file, and the parsed table.
    See `Scenario.from_toml` for the parameter.

    Raises
    ------
    ScenarioFileError
        If the source is empty or is not valid TOML.
    """
    is_text = isinstance(source, str) and ("\n" in source or not source.endswith(".toml"))
    origin, folder = ("TOML text", Path()) if is_text else (os.fspath(source), Path(source).parent)
    try:
        text = str(source) if is_text else Path(source).read_text(encoding="utf-8-sig")
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        hint = " (a file name must end in .toml)" if is_text else ""
        raise ScenarioFileError(f"{origin}{hint}: not TOML: {error}") from None
    if not table:
        raise ScenarioFileError(f'{origin}: empty; the shortest scenario is: preset = "paper"')
    return origin, folder, table


def to_toml(scenario: Settings, table: Mapping[str, Any], notes: Mapping[str, str]) -> str:
    """Format a scenario as the text of a TOML file, with a comment on every key.

    Parameters
    ----------
    scenario : Settings
        Scenario whose fields are described in the comments.
    table : mapping
        Result of `Scenario.to_dict`.
    notes : mapping of str to str
        Additional comments at the end of tables, keyed by table name.
    """
    head, tables = [_HEADER], []
    for key, value in table.items():
        settings = getattr(scenario, key)
        if isinstance(value, Mapping):
            meaning = build_schema(type(scenario))["properties"][key]["description"]
            tables += ["", f"[{key}] # {meaning}", *_format_lines(value, settings)]
        elif isinstance(value, list) and isinstance(value[0], Mapping):
            for entry, each in zip(value, settings, strict=True):
                tables += ["", f"[[{key}]]", *_format_lines(entry, each)]
        else:
            head += _format_lines({key: value}, scenario)
        tables += [f"# {notes[key]}"] if key in notes else []
    return "\n".join([*head, *tables, ""])


def _format_lines(values: Mapping[str, Any], settings: Any) -> Iterator[str]:
    """Yield one TOML line per key, with a comment on the meaning, range and unit of its value."""
    properties = (
        build_schema(type(settings))["properties"] if isinstance(settings, Settings) else {}
    )
    for key, value in values.items():
        attribute = getattr(settings, key, None)
        if isinstance(attribute, datetime):  # TOML has a type for date and time.
            value = attribute
        schema = properties.get(key)
        comment = f" # {schema.get('description', '')}: {describe_schema(schema)}" if schema else ""
        text = f"{_format_value(value)}{comment}"
        if isinstance(value, list) and isinstance(
            value[0], list | Mapping
        ):  # Each row is on its own line.
            rows = (f"  {_format_value(row)},\n" for row in value)
            text = f"[{comment}\n{''.join(rows)}]"
        yield f"{tomlkit.key(key).as_string()} = {text}"


def _format_value(value: Any) -> str:
    item = tomlkit.inline_table() if isinstance(value, Mapping) else tomlkit.item(value)
    if isinstance(value, Mapping):
        item.update(value)
    return item.as_string()
