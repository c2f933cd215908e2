"""Plan files: export in all formats, and reading of plans in JSON.

In JSON, ``scenario`` and ``design`` define the plan. The entries ``predicted``, ``constraints``,
``timeline`` and ``accuracy`` are for readers of the file: they are ignored and computed again when
the file is read. Floats are written in full precision, except in the table of commands.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from mgeo.plugins.review import build_records
from mgeo.store.atomic import write_file
from mgeo.validation.arguments import reject_unknown_keywords
from mgeo.validation.entries import get_entry
from mgeo_attitude.export_formats import FORMATS, find_format
from mgeo_attitude.plan.documents import DocumentFormat, read_document, serialize
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.problem import PLAN_FORMAT

if TYPE_CHECKING:
    from mgeo_attitude.documents import PredictedEnd


def write_plan(plan: ManeuverPlan, path: Path | str, **options: Any) -> None:
    """Write a plan to a file, in the format that matches the suffix of the file name.

    The file is written atomically.

    Parameters
    ----------
    plan : ManeuverPlan
    path : path
        File with a suffix of `mgeo_attitude.export_formats.FORMATS`, such as ``.json``.
    options
        Keyword arguments of the format's function, such as `format_aem`. Arguments of other formats
        are ignored.

    Raises
    ------
    ValueError
        If the suffix is unknown, or if the format's function raises one.
    TypeError
        If no format has one of the options.
    ImportError
        If the format needs a package that is not installed.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, read_json, write_plan
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> write_plan(plan, "plan.json")
    >>> read_json("plan.json") == plan
    True
    """
    write_file(path, build_plan_content(plan, path, options))


def build_plan_content(plan: ManeuverPlan, path: Path | str, options: Mapping[str, Any]) -> bytes:
    """Return the bytes that `write_plan` writes to a file.

    The exceptions are those of `write_plan`.
    """
    chosen = find_format(path)
    reject_unknown_keywords(
        options, {key for each in FORMATS for key in each.list_options()}, "write_plan"
    )
    content = chosen.load()(plan, **{k: options[k] for k in chosen.list_options() if k in options})
    return content.encode() if isinstance(content, str) else content


def to_csv(plan: ManeuverPlan) -> str:
    """Return the timeline of a plan as CSV text, with a header line and one row per phase.

    The column ``row`` has entries such as 2/4, so that missing rows are noticed. Lines before the
    header that begin with # list violated constraints.

    Parameters
    ----------
    plan : ManeuverPlan

    Returns
    -------
    str

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, to_csv
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> to_csv(plan).splitlines()[0].split(",")[:4]
    ['row', 'phase', 'start [s]', 'end [s]']
    """
    table = plan.build_timeline()
    rows = [f"{i + 1}/{len(table)}" for i in range(len(table))]
    return format_csv(plan, table.set_axis(rows, axis=0), index_label="row")


def format_csv(plan: ManeuverPlan, table: pd.DataFrame, **options: Any) -> str:
    """Convert a table to CSV text that begins with comments on violated constraints of a plan.

    Parameters
    ----------
    plan : ManeuverPlan
    table : DataFrame
    options
        Keyword arguments of `DataFrame.to_csv`.

    Returns
    -------
    str
    """
    comments = "".join(
        f"# VIOLATED CONSTRAINT: {violation}\n" for violation in plan.list_violations()
    )
    return comments + str(table.to_csv(lineterminator="\n", **options))


def to_json(plan: ManeuverPlan) -> str:
    """Return a plan as JSON text that `from_json` can read, with floats in full precision.

    Parameters
    ----------
    plan : ManeuverPlan

    Returns
    -------
    str

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, from_json, to_json
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> from_json(to_json(plan)) == plan
    True
    """
    return serialize(build_document(plan))


def build_document(plan: ManeuverPlan) -> dict[str, Any]:
    """Convert a plan to a dict with the contents of its JSON file."""
    return _FORMAT.build_document(plan)


def from_json(text: str) -> ManeuverPlan:
    """Construct a plan from the JSON text that `to_json` returns.

    Parameters
    ----------
    text : str

    Returns
    -------
    ManeuverPlan

    Raises
    ------
    ValueError, TypeError
        If the text is not JSON, if its format or version differs, or if an entry is missing or
        invalid. The message names the key.

    Examples
    --------
    >>> from mgeo_attitude.plan import from_json
    >>> from_json("{}")
    Traceback (most recent call last):
        ...
    ValueError: format = None: expected 'mgeo-attitude-plan'
    """
    return _FORMAT.parse(text)


def read_json(path: Path | str) -> ManeuverPlan:
    """Read a plan from a ``.json`` file that was written by `write_plan`.

    Parameters
    ----------
    path : path

    Returns
    -------
    ManeuverPlan

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If the document is invalid; the message names the file and the key. See `from_json`.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, read_json, write_plan
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> write_plan(plan, "plan.json")
    >>> read_json("plan.json").design == plan.design
    True
    """
    return read_document(path, from_json)


def _derive_entries(plan: ManeuverPlan) -> dict[str, Any]:
    predicted: PredictedEnd = {
        "t_end_s": plan.t_end,
        "trace": plan.trace,
        "attitude_1sigma_deg": plan.attitude_sigma_deg,
        "converged": plan.converged,
    }
    if plan.describe_hold():
        predicted["hold_end_s"] = plan.hold_end
    if plan.slew_back:
        predicted["slew_back_end_s"] = plan.duration
    return {
        "predicted": predicted,
        # The last digits of a margin depend on the libraries, since it is a difference of close
        # numbers.
        "constraints": build_records(plan.build_constraint_table().drop(columns="margin")),
        "timeline": build_records(plan.build_timeline()),
        "accuracy": build_records(plan.build_accuracy_table()),
    }


_FORMAT = DocumentFormat(
    PLAN_FORMAT,
    3,
    defining_entries=lambda plan: {
        "scenario": plan.scenario.to_dict(),
        "design": list(plan.design),
    },
    build=lambda entries, scenario: ManeuverPlan(
        scenario, tuple(get_entry(entries, "design", list))
    ),
    derived_entries=_derive_entries,
)
