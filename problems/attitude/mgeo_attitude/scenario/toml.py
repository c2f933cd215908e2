"""Scenario files: TOML with a comment on every key, errors that name file and key."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.items import Item, Table

from ..fields import Validated, declared
from ..files import write_text
from ..sensors import SENSORS
from .presets import PRESETS
from .scenario import Scenario
from .settings import state_units
from .tables import from_table, to_table


class ScenarioFileError(ValueError):
    """A scenario file, or text, that cannot be read; the message says which and where."""


def from_toml(source: str | os.PathLike[str]) -> Scenario:
    """Read a scenario from a file or text; see `Scenario.from_toml`."""
    if isinstance(source, str) and ("\n" in source or not source.endswith(".toml")):
        hint = "" if "\n" in source else " (a file's name would end in .toml)"
        return _parsed(f"TOML text{hint}", source)
    try:
        text = Path(source).read_text(encoding="utf-8-sig")  # some editors write a byte-order mark
    except UnicodeDecodeError as error:
        raise ScenarioFileError(f"{source}: not TOML, which is UTF-8: {error}") from None
    return _parsed(os.fspath(source), text)


def save(scenario: Scenario, path: str | os.PathLike[str]) -> None:
    """Write the scenario to a file, which is replaced as a whole or not at all."""
    write_text(Path(path), to_toml(scenario))


def to_toml(scenario: Scenario) -> str:
    """The scenario as a TOML document; `from_toml` gives back an equal scenario."""
    presets = " or ".join(f'"{preset}"' for preset in PRESETS)
    document = tomlkit.document()
    document.add(
        tomlkit.comment("Scenario of mgeo-attitude. A file may also start from a preset and say")
    )
    document.add(tomlkit.comment(f"only what differs: preset = {presets}"))
    document.add(tomlkit.nl())
    table = to_table(scenario) | {"epoch": scenario.epoch}
    comments = _comments(scenario)
    for key, value in table.items():
        section = getattr(scenario, key)
        if isinstance(section, Validated):
            document.add(key, _table(value, _comments(section), comments[key]))
        elif key in ("sensors", "keep_outs"):
            entries = tomlkit.aot()
            for entry, part in zip(value, section, strict=True):
                entries.append(_table(entry, _comments(part)))
            document.add(key, entries)
        elif key in ("trace_weights", "required_sigma"):
            values = _table(value, {}, comments[key])
            units = state_units(scenario.gyro, scenario.sensors)
            required = key == "required_sigma"
            keys = [unit.key(block) if required else block for block, unit in units.items()]
            values.add(tomlkit.comment(f"The blocks: {', '.join(keys)}"))
            document.add(key, values)
        else:
            document.add(key, _item(value, comments[key]))
    return tomlkit.dumps(document)


def _parsed(origin: str, text: str) -> Scenario:
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also of a number of thousands of digits
        raise ScenarioFileError(f"{origin}: not TOML: {error}") from None
    if not table:
        raise ScenarioFileError(f'{origin}: empty; the least it can say is preset = "paper"')
    try:
        return from_table(table)
    except ValueError as error:
        raise ScenarioFileError(f"{origin}: {error}") from error


def _comments(section: Validated) -> dict[str, str]:
    """The comment of each key: its meaning, then the range or the choices."""
    comments = {
        "kind": f"one of {', '.join(map(repr, SENSORS))}",
        "propagator": "SGP4 with a two-line element set",
    }
    for key, (_, spec) in declared(type(section)).items():
        limits = ", ".join(map(repr, spec.choices)) or spec.range_text()
        comments[key] = f"{spec.doc}: {limits}" if limits else spec.doc
    return comments


def _table(values: Mapping[str, Any], comments: Mapping[str, str], comment: str = "") -> Table:
    table = tomlkit.table()
    if comment:
        table.comment(comment)
    for key, value in values.items():
        table.add(key, _item(value, comments.get(key, "")))
    return table


def _item(value: Any, comment: str) -> Item:
    item: Item = tomlkit.item(value)
    return item.comment(comment) if comment else item
