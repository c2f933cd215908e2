"""Plans as files: JSON that reads back, CSV of timeline and commands, attitudes for other tools.

In JSON, ``scenario`` and ``design`` are the plan. ``predicted``, ``constraints``, ``timeline`` and
``accuracy`` follow from them; on reading they are computed again, and a file that says something
else is refused. CSV says less than the plan. Floats are written to the last digit, but in commands.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import getfullargspec
from pathlib import Path
from typing import Any

from mgeo.store.atomic import write_file
from mgeo.validation.arguments import refuse_unknown
from mgeo.validation.entries import entry
from mgeo_attitude.plan.aem import aem_text
from mgeo_attitude.plan.attitudes import script_text, stk_text, waypoints_text
from mgeo_attitude.plan.documents import Form, read_document, written
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.plan.spice import ck_bytes, sclk_text
from mgeo_attitude.plan.uplink import to_uplink_csv
from mgeo_attitude.problem import PLAN_FORMAT


def write_plan(plan: ManeuverPlan, path: Path | str, **options: Any) -> None:
    """Write a plan to a file, whole or not at all, in the format that its name ends in.

    Parameters
    ----------
    path : path
        Ends in ``.json`` (`to_json`), ``.uplink.csv`` (`to_uplink_csv`), ``.aem`` (`aem_text`),
        ``.a`` (`stk_text`), ``.42.txt`` (`script_text`), ``.waypoints.csv`` (`waypoints_text`),
        ``.bc`` (`ck_bytes`), ``.tsc`` (`sclk_text`), or any other ``.csv`` (`to_csv`).
    options
        Keywords of these; those that a format does not take are passed over.

    Raises
    ------
    ValueError
        For another ending, or by the function.
    TypeError
        For a keyword that no format takes.
    ImportError
        If a format needs an extra that is not installed.
    OSError
        If it cannot be written.

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
    write_file(path, plan_content(plan, path, options))


def plan_content(plan: ManeuverPlan, path: Path | str, options: Mapping[str, Any]) -> bytes:
    """What a file of this name holds; raises as `write_plan`."""
    suffixes = [suffix for suffix in WRITERS if Path(path).name.endswith(suffix)]
    if not suffixes:
        raise ValueError(f"{path}: expected a name that ends in {', '.join(WRITERS)}")
    writer = WRITERS[max(suffixes, key=len)]
    refuse_unknown(
        options, {key for each in WRITERS.values() for key in _taken(each)}, "write_plan"
    )
    content = writer(plan, **{key: options[key] for key in _taken(writer) if key in options})
    return content.encode() if isinstance(content, str) else content


def _taken(writer: Callable[..., str | bytes]) -> list[str]:
    """Keywords of `write_plan` that a format takes."""
    return getfullargspec(writer).kwonlyargs


def to_csv(plan: ManeuverPlan) -> str:
    """The timeline as CSV with a header, one row per phase.

    A column ``row``, such as 2/4, tells of rows that were lost. Lines that begin with # stand
    before the header where the plan violates constraints, and name them.

    Parameters
    ----------
    plan : ManeuverPlan

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, to_csv
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> to_csv(plan).splitlines()[0].split(",")[:4]
    ['row', 'phase', 'start [s]', 'end [s]']
    """
    table = plan.timeline()
    rows = [f"{i + 1}/{len(table)}" for i in range(len(table))]
    comments = "".join(f"# VIOLATED CONSTRAINT: {violation}\n" for violation in plan.violations())
    text: str = table.set_axis(rows, axis=0).to_csv(index_label="row", lineterminator="\n")
    return comments + text


def to_json(plan: ManeuverPlan) -> str:
    """The plan as a JSON document; floats by repr, so that it reads back exactly.

    Parameters
    ----------
    plan : ManeuverPlan

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, from_json, to_json
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> from_json(to_json(plan)) == plan
    True
    """
    return written(document(plan))


def document(plan: ManeuverPlan) -> dict[str, Any]:
    """What `to_json` writes, as JSON values."""
    return _FORM.document(plan)


def from_json(text: str) -> ManeuverPlan:
    """Inverse of `to_json`; raises as `Form.read`.

    Parameters
    ----------
    text : str

    Examples
    --------
    >>> from mgeo_attitude.plan import from_json
    >>> from_json("{}")
    Traceback (most recent call last):
        ...
    ValueError: format = None: expected 'mgeo-attitude-plan'
    """
    return _FORM.read(text)


def read_json(path: Path | str) -> ManeuverPlan:
    """Read what `write_plan` wrote to a ``.json`` file.

    Parameters
    ----------
    path : path

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        Naming the file and the key, see `from_json`.

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


def _consequences(plan: ManeuverPlan) -> dict[str, Any]:
    held = {"held until [s]": plan.held_until} if plan.late() else {}
    slew_back = {"slew back until [s]": plan.duration} if plan.slew_back else {}
    return {
        "predicted": {
            "t_end [s]": plan.t_end,
            "trace [-]": plan.trace,
            "attitude 1-sigma [deg]": plan.attitude_sigma_deg,
            "converged": plan.history.converged,
            **held,
            **slew_back,
        },
        # without margins: differences of near numbers, which other libraries round otherwise
        "constraints": plan.constraints().drop(columns="margin").reset_index().to_dict("records"),
        "timeline": plan.timeline().to_dict("records"),
        "accuracy": plan.accuracy().reset_index().to_dict("records"),
    }


_FORM = Form(
    PLAN_FORMAT,
    3,
    keys=lambda plan: {"scenario": plan.scenario.to_dict(), "design": list(plan.design)},
    made=lambda table, scenario: ManeuverPlan(scenario, tuple(entry(table, "design", list))),
    consequences=_consequences,
    source="the design",
    older=(2,),  # another 1-sigma of the attitude, and path limits at samples alone
)

#: By what a name may end in, what makes such a file.
WRITERS: Mapping[str, Callable[..., str | bytes]] = {
    ".json": to_json,
    ".uplink.csv": to_uplink_csv,
    ".csv": to_csv,
    ".aem": aem_text,
    ".a": stk_text,
    ".42.txt": script_text,
    ".waypoints.csv": waypoints_text,
    ".bc": ck_bytes,
    ".tsc": sclk_text,
}
