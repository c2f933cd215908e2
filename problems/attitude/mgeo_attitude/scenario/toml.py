"""Scenario files: TOML with a comment on every key, and presets to start from."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterator, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

import tomlkit

from mgeo_attitude.environment.orbit import ORBITS
from mgeo_attitude.settings.base import Settings, schema_of
from mgeo_attitude.settings.errors import InvalidValue, known_names
from mgeo_attitude.settings.words import describe

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
    name = ORBITS.name_of(orbit) if isinstance(orbit, Mapping) else None
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


#: The schema of a scenario file for editors, beside it: the output of the command ``schema``.
SCHEMA_FILE = "scenario.schema.json"

_HEADER = f"""\
#:schema ./{SCHEMA_FILE}
# Scenario of mgeo-attitude. A file may also start from a preset and say
# only what differs: preset = {" or ".join(f'"{preset}"' for preset in PRESETS)}
"""


class ScenarioFileError(ValueError):
    """A scenario file, or text, that cannot be read; the message says which and where."""


def read_toml(source: str | os.PathLike[str]) -> tuple[str, Path, Table]:
    """Return the name of a file or text in messages, its folder and its table.

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
    """Write a scenario's table as a document, with `notes` below the tables of these keys."""
    head, tables = [_HEADER], []
    for key, value in table.items():
        part = getattr(scenario, key)
        if isinstance(value, Mapping):
            meaning = schema_of(type(scenario))["properties"][key]["description"]
            tables += ["", f"[{key}] # {meaning}", *_lines(value, part)]
        elif isinstance(value, list) and isinstance(value[0], Mapping):
            for entry, own in zip(value, part, strict=True):
                tables += ["", f"[[{key}]]", *_lines(entry, own)]
        else:
            head += _lines({key: value}, scenario)
        tables += [f"# {notes[key]}"] if key in notes else []
    return "\n".join([*head, *tables, ""])


def _lines(values: Mapping[str, Any], settings: Any) -> Iterator[str]:
    """Yield each key and value with a comment: its meaning, range and unit."""
    properties = schema_of(type(settings))["properties"] if isinstance(settings, Settings) else {}
    for key, value in values.items():
        own = getattr(settings, key, None)
        value = own if isinstance(own, datetime) else value  # TOML has them
        schema = properties.get(key)
        comment = f" # {schema.get('description', '')}: {describe(schema)}" if schema else ""
        text = f"{_text(value)}{comment}"
        if isinstance(value, list) and isinstance(value[0], list | Mapping):  # a row a line
            rows = (f"  {_text(row)},\n" for row in value)
            text = f"[{comment}\n{''.join(rows)}]"
        yield f"{tomlkit.key(key).as_string()} = {text}"


def _text(value: Any) -> str:
    """A value on one line."""
    item = tomlkit.inline_table() if isinstance(value, Mapping) else tomlkit.item(value)
    if isinstance(value, Mapping):
        item.update(value)
    return item.as_string()
