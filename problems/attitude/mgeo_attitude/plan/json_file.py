"""Plans as JSON: what is to be flown, and what follows from it for readers without this package.

``scenario`` and ``design`` are the plan. ``predicted``, ``constraints``, ``timeline`` and
``accuracy`` follow from them; on reading they are computed again, and a file that says something
else is refused.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from mgeo.files.atomic import write_file
from mgeo.files.reading import entry, errors_of, parse_json, read_text
from mgeo_attitude.fields import InvalidValue
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.scenario import Scenario

FORMAT = "mgeo-attitude-plan"
VERSION = 1

#: A plan of 100 maneuvers is far smaller.
MOST_BYTES = 64 * 2**20

#: Numbers that were computed again, perhaps by other libraries, may differ by this fraction.
TOLERANCE = 1e-6

_KEYS = {
    "format": str,
    "version": int,
    "scenario": dict,
    "design": list,
    "predicted": dict,
    "constraints": list,
    "timeline": list,
    "accuracy": list,
}


def to_json(plan: ManeuverPlan) -> str:
    """The plan as a JSON document; floats by repr, so that it reads back exactly."""
    table = {
        "format": FORMAT,
        "version": VERSION,
        "scenario": plan.scenario.to_dict(),
        "design": list(plan.design),
        **_consequences(plan),
    }
    return json.dumps(table, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def from_json(text: str) -> ManeuverPlan:
    """Inverse of `to_json`.

    Raises
    ------
    ValueError, TypeError
        If the text is no JSON, of another format or version, or a key is missing, unknown, of a bad
        value, or does not follow from the design; the message names the key.
    """
    table = parse_json(text)
    _check_format(table)
    for key in table:
        if key not in _KEYS:
            raise InvalidValue(key, table[key], f"expected {', '.join(_KEYS)}")
    for key, kind in _KEYS.items():
        entry(table, key, kind)
    try:
        scenario = Scenario.from_dict(table["scenario"])
    except InvalidValue as error:
        raise error.under("scenario") from None
    plan = ManeuverPlan(scenario, tuple(table["design"]))
    for key, expected in _consequences(plan).items():
        _check_same(key, table[key], expected)
    return plan


def write_json(plan: ManeuverPlan, path: Path | str) -> None:
    """Write `to_json` to a file, whole or not at all."""
    write_file(path, to_json(plan).encode())


def read_json(path: Path | str) -> ManeuverPlan:
    """Read what `write_json` wrote.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        Naming the file and the key, see `from_json`.
    """
    text = read_text(path, MOST_BYTES)
    with errors_of(path):
        return from_json(text)


def _consequences(plan: ManeuverPlan) -> dict[str, Any]:
    return {
        "predicted": {
            "t_end [s]": plan.t_end,
            "trace [-]": plan.trace,
            "converged": plan.history.converged,
        },
        # without margins: differences of near numbers, which other libraries round otherwise
        "constraints": plan.constraints().drop(columns="margin").reset_index().to_dict("records"),
        "timeline": plan.timeline().to_dict("records"),
        "accuracy": plan.accuracy().reset_index().to_dict("records"),
    }


def _check_format(table: Any) -> None:
    found = table.get("format") if isinstance(table, dict) else None
    if found != FORMAT:
        raise ValueError(f"format = {found!r}: expected {FORMAT!r}")
    version = table.get("version")
    if version != VERSION or isinstance(version, bool):
        raise ValueError(f"version = {version!r}: this package reads version {VERSION}")


def _check_same(key: str, found: Any, expected: Any) -> None:
    """Refuse data that is not what it should be: numbers within `TOLERANCE`, the rest equal.

    Raises
    ------
    InvalidValue
        Naming the first key that differs.
    """
    if isinstance(expected, dict) and isinstance(found, dict) and found.keys() == expected.keys():
        for name in expected:
            _check_same(f"{key}.{name}", found[name], expected[name])
    elif isinstance(expected, list) and isinstance(found, list) and len(found) == len(expected):
        for i, (one, other) in enumerate(zip(found, expected, strict=True)):
            _check_same(f"{key}[{i}]", one, other)
    elif isinstance(expected, float) and type(found) in (int, float):
        # no fraction of a number that is zero but for rounding, as in a quaternion
        close = TOLERANCE * max(abs(expected), TOLERANCE)
        if not expected - close <= found <= expected + close:
            raise InvalidValue(key, found, f"expected {expected!r}, which follows from the design")
    elif type(found) is not type(expected) or found != expected:
        raise InvalidValue(key, found, f"expected {expected!r}, which follows from the design")
