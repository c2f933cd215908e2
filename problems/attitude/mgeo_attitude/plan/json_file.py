"""Plans as JSON: what is to be flown, and what follows from it for readers without this package.

``scenario`` and ``design`` are the plan. ``predicted``, ``constraints``, ``timeline`` and
``accuracy`` follow from them; on reading they are computed again, and a file that says something
else is refused.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from ..fields import InvalidValue
from ..files import write_text
from ..scenario import Scenario
from .plan import ManeuverPlan
from .reading import check_same, checked_keys, errors_of, parse_json, read_text

FORMAT = "mgeo-attitude-plan"
VERSION = 1

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
    checked_keys("", table, _KEYS)
    try:
        scenario = Scenario.from_dict(table["scenario"])
    except InvalidValue as error:
        raise error.under("scenario") from None
    plan = ManeuverPlan(scenario, tuple(table["design"]))
    for key, expected in _consequences(plan).items():
        check_same(key, table[key], expected)
    return plan


def write_json(plan: ManeuverPlan, path: str | os.PathLike[str]) -> None:
    """Write `to_json` to a file, whole or not at all."""
    write_text(Path(path), to_json(plan))


def read_json(path: str | os.PathLike[str]) -> ManeuverPlan:
    """Read what `write_json` wrote.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        Naming the file and the key, see `from_json`.
    """
    path = Path(path)
    with errors_of(path):
        return from_json(read_text(path))


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
