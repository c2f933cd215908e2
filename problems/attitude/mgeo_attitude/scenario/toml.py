"""Scenario files in TOML with a comment on every key, and presets."""

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

#: Names of the presets, each a file in this folder.
PRESETS = ("paper", "cubesat_1u", "cubesat_6u", "cubesat_6u_full", "microsatellite")


def merge_preset(table: Mapping[str, Any]) -> Table:
    """Merge a table into the preset that it names, if any; see `Scenario.from_dict`."""
    overrides = dict(table)
    if "preset" not in overrides:
        return overrides
    preset = overrides.pop("preset")
    if not isinstance(preset, str) or preset not in PRESETS:
        raise InvalidValue("preset", preset, f"unknown preset{format_known_names(preset, PRESETS)}")
    file = Path(__file__).with_name(f"{preset}.toml")
    return merge_table(merge_preset(tomllib.loads(file.read_text(encoding="utf-8"))), overrides)


def merge_table(base: Table, table: Mapping[str, Any]) -> Table:
    """Merge a table into a complete table, key by key."""
    overrides = dict(table)
    if _find_orbit_class(overrides) not in (None, _find_orbit_class(base)):
        base = {key: base[key] for key in base if key != "orbit"}  # kinds of orbits share no keys
    sensors = overrides.get("sensors")
    if isinstance(sensors, list | tuple):
        overrides["sensors"] = [_merge_sensor(entry, base["sensors"]) for entry in sensors]
    return _merge(base, overrides)


def _find_orbit_class(table: Table) -> type | None:
    """Return the class of the orbit in a table; None if it is not determined."""
    orbit = table.get("orbit")
    name = ORBITS.get_class_name(orbit) if isinstance(orbit, Mapping) else None
    return ORBITS.classes.get(name) if isinstance(name, str) else None


def _merge_sensor(table: Any, preset: list[Table]) -> Any:
    """Merge a sensor into the preset's sensor of its name and kind, or the only one of its kind."""
    if not isinstance(table, Mapping):
        return table
    name, kind = table.get("name"), table.get("kind")
    same = [one for one in preset if one["name"] == name and kind in (None, one["kind"])]
    same = same or [one for one in preset if one["kind"] == kind]
    return {**same[0], **table} if len(same) == 1 else table


def _merge(base: Table, overrides: Mapping[str, Any]) -> Table:
    merged = dict(base)
    for key, value in overrides.items():
        nested = isinstance(value, Mapping) and isinstance(merged.get(key), Mapping)
        merged[key] = _merge(merged[key], value) if nested else value
    return merged


#: Name of the schema for editors in a scenario file's folder: the output of the command ``schema``.
SCHEMA_FILE = "scenario.schema.json"

_HEADER = f"""\
#:schema ./{SCHEMA_FILE}
# Scenario of mgeo-attitude. A file may also start from a preset and say
# only what differs: preset = {" or ".join(f'"{preset}"' for preset in PRESETS)}
"""


class ScenarioFileError(ValueError):
    """Scenario file or text that cannot be read; the message names file and place."""


def read_toml(source: str | os.PathLike[str]) -> tuple[str, Path, Table]:
    """Return the display name of a file or text, its folder and its table.

    See `Scenario.from_toml`.
    """
    is_text = isinstance(source, str) and ("\n" in source or not source.endswith(".toml"))
    origin, folder = ("TOML text", Path()) if is_text else (os.fspath(source), Path(source).parent)
    try:
        text = str(source) if is_text else Path(source).read_text(encoding="utf-8-sig")
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        hint = " (the name of a file ends in .toml)" if is_text else ""
        raise ScenarioFileError(f"{origin}{hint}: not TOML: {error}") from None
    if not table:
        raise ScenarioFileError(f'{origin}: empty; the shortest scenario is preset = "paper"')
    return origin, folder, table


def to_toml(scenario: Settings, table: Mapping[str, Any], notes: Mapping[str, str]) -> str:
    """Serialize a scenario's table as TOML.

    Parameters
    ----------
    scenario : Settings
    table : mapping
        Result of `Scenario.to_dict`.
    notes : mapping
        Comments below the tables of these keys.
    """
    head, tables = [_HEADER], []
    for key, value in table.items():
        part = getattr(scenario, key)
        if isinstance(value, Mapping):
            meaning = build_schema(type(scenario))["properties"][key]["description"]
            tables += ["", f"[{key}] # {meaning}", *_format_lines(value, part)]
        elif isinstance(value, list) and isinstance(value[0], Mapping):
            for entry, own in zip(value, part, strict=True):
                tables += ["", f"[[{key}]]", *_format_lines(entry, own)]
        else:
            head += _format_lines({key: value}, scenario)
        tables += [f"# {notes[key]}"] if key in notes else []
    return "\n".join([*head, *tables, ""])


def _format_lines(values: Mapping[str, Any], settings: Any) -> Iterator[str]:
    """Yield each key and value with a comment on meaning, range and unit."""
    properties = (
        build_schema(type(settings))["properties"] if isinstance(settings, Settings) else {}
    )
    for key, value in values.items():
        own = getattr(settings, key, None)
        value = own if isinstance(own, datetime) else value  # TOML has a type for date and time
        schema = properties.get(key)
        comment = f" # {schema.get('description', '')}: {describe_schema(schema)}" if schema else ""
        text = f"{_format_value(value)}{comment}"
        if isinstance(value, list) and isinstance(value[0], list | Mapping):  # one line per row
            rows = (f"  {_format_value(row)},\n" for row in value)
            text = f"[{comment}\n{''.join(rows)}]"
        yield f"{tomlkit.key(key).as_string()} = {text}"


def _format_value(value: Any) -> str:
    item = tomlkit.inline_table() if isinstance(value, Mapping) else tomlkit.item(value)
    if isinstance(value, Mapping):
        item.update(value)
    return item.as_string()
