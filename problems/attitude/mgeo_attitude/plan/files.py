"""Plans as files: JSON that reads back, CSV of timeline and commands, CCSDS attitude ephemeris.

In JSON, ``scenario`` and ``design`` are the plan. ``predicted``, ``constraints``, ``timeline`` and
``accuracy`` follow from them; on reading they are computed again, and a file that says something
else is refused. CSV says less than the plan; floats are written to the last digit in both.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mgeo.files.atomic import write_file
from mgeo.files.reading import entry, errors_of, parse_json, read_text
from mgeo_attitude.fields import InvalidValue
from mgeo_attitude.plan.aem import aem_text
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.plan.uplink import to_uplink_csv
from mgeo_attitude.scenario import Scenario

SUFFIXES = (".json", ".uplink.csv", ".csv", ".aem")

FORMAT = "mgeo-attitude-plan"
VERSION = 2

#: A plan of 100 maneuvers is far smaller.
MOST_BYTES = 64 * 2**20

#: Numbers that were computed again, perhaps by other libraries, may differ by this fraction.
TOLERANCE = 1e-6


def write_plan(plan: ManeuverPlan, path: Path | str, **aem: Any) -> None:
    """Write a plan to a file, whole or not at all, in the format that its name ends in.

    Parameters
    ----------
    path : path
        Ends in ``.json`` (`to_json`), ``.uplink.csv`` (`to_uplink_csv`), any other ``.csv``
        (`to_csv`) or ``.aem`` (`aem_text`).
    aem
        Keywords of `aem_text`.

    Raises
    ------
    ValueError
        For another ending, or by `aem_text`.
    OSError
        If it cannot be written.
    """
    write_file(path, plan_text(plan, path, aem).encode())


def plan_text(plan: ManeuverPlan, path: Path | str, aem: Mapping[str, Any]) -> str:
    """What a file of this name holds; raises as `write_plan`."""
    suffix = ending(path)
    if suffix == ".aem":
        return aem_text(plan, **aem)
    writers = {".json": to_json, ".uplink.csv": to_uplink_csv, ".csv": to_csv}
    return writers[suffix](plan)


def ending(path: Path | str) -> str:
    """Which of `SUFFIXES` a name ends in; ValueError for none."""
    for suffix in SUFFIXES:
        if Path(path).name.endswith(suffix):
            return suffix
    raise ValueError(f"{path}: expected a name that ends in {', '.join(SUFFIXES)}")


def to_csv(plan: ManeuverPlan) -> str:
    """The timeline as CSV with a header, one row per phase.

    A column ``row``, such as 2/4, tells of rows that were lost. Lines that begin with # stand
    before the header where the plan violates constraints, and name them.
    """
    table = plan.timeline()
    rows = [f"{i + 1}/{len(table)}" for i in range(len(table))]
    comments = "".join(f"# VIOLATED CONSTRAINT: {violation}\n" for violation in plan.violations())
    text: str = table.set_axis(rows, axis=0).to_csv(index_label="row", lineterminator="\n")
    return comments + text


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
    found = table.get("format") if isinstance(table, dict) else None
    if found != FORMAT:
        raise ValueError(f"format = {found!r}: expected {FORMAT!r}")
    version = table.get("version")
    if version != VERSION or isinstance(version, bool):
        raise ValueError(f"version = {version!r}: this package reads version {VERSION}")
    try:
        scenario = Scenario.from_dict(entry(table, "scenario", dict))
    except InvalidValue as error:
        raise error.under("scenario") from None
    plan = ManeuverPlan(scenario, tuple(entry(table, "design", list)))
    consequences = _consequences(plan)
    known = ["format", "version", "scenario", "design", *consequences]
    for key in table:
        if key not in known:
            raise InvalidValue(key, table[key], f"expected {', '.join(known)}")
    for key, expected in consequences.items():
        check_same(key, entry(table, key, type(expected)), expected, "the design")
    return plan


def read_json(path: Path | str) -> ManeuverPlan:
    """Read what `write_plan` wrote to a ``.json`` file.

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
    slew_back = {"slew back until [s]": plan.duration} if plan.slew_back else {}
    return {
        "predicted": {
            "t_end [s]": plan.t_end,
            "trace [-]": plan.trace,
            "attitude accuracy [deg]": plan.attitude_accuracy_deg,
            "converged": plan.history.converged,
            **slew_back,
        },
        # without margins: differences of near numbers, which other libraries round otherwise
        "constraints": plan.constraints().drop(columns="margin").reset_index().to_dict("records"),
        "timeline": plan.timeline().to_dict("records"),
        "accuracy": plan.accuracy().reset_index().to_dict("records"),
    }


def check_same(key: str, found: Any, expected: Any, source: str) -> None:
    """Refuse other data than follow from a source, naming the first key.

    Numbers may be off by `TOLERANCE`.

    Raises
    ------
    InvalidValue
    """
    if isinstance(expected, dict) and isinstance(found, dict) and found.keys() == expected.keys():
        for name in expected:
            check_same(f"{key}.{name}", found[name], expected[name], source)
        return
    if isinstance(expected, list) and isinstance(found, list) and len(found) == len(expected):
        for i, (one, other) in enumerate(zip(found, expected, strict=True)):
            check_same(f"{key}[{i}]", one, other, source)
        return
    if isinstance(expected, float) and type(found) in (int, float):
        # no fraction of a number that is zero but for rounding, as in a quaternion
        close = TOLERANCE * max(abs(expected), TOLERANCE)
        same = expected - close <= found <= expected + close
    else:
        same = type(found) is type(expected) and found == expected
    if not same:
        raise InvalidValue(key, found, f"expected {expected!r}, which follows from {source}")
