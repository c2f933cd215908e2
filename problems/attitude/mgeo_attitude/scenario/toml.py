"""Scenario files: TOML with a comment on every key, errors that name the file."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterator, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

import tomlkit

from mgeo_attitude.fields import Validated, declared
from mgeo_attitude.scenario.presets import PRESETS

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
        from mgeo.validation.tables import FileError

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
