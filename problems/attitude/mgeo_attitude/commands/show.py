"""Output of ``mgeo attitude show``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.console import RenderableType

from mgeo.figures.page import render_report_page
from mgeo.store.atomic import write_file
from mgeo.terminal import Output, build_titled_table, escape_text, format_note, to_records
from mgeo_attitude.bound.samples import NoLowerBoundError
from mgeo_attitude.commands.files import Picked
from mgeo_attitude.criteria.objectives import attitude_accuracy_deg
from mgeo_attitude.plan.figures import plan_figures
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.plan.tables import TABLES, PlanTable


def print_plan(picked: Picked, output: Output) -> None:
    """Print the summary of a plan, warnings and all tables."""
    plan = picked.plan
    orbits = plan.t_end / plan.scenario.orbit.period
    output.print(
        escape_text(picked.answer, "bold"),
        *picked.doubts(),
        f"scenario {plan.scenario.name}: {_ended(plan)} at {plan.t_end:.6g} s ({orbits:.3f} "
        f"orbits), trace {plan.trace:.4g}",
        *plan.limit(),
        *plan.late(),
    )
    for table in TABLES.values():
        output.print(*render_table(table, plan))


def render_table(table: PlanTable, plan: ManeuverPlan) -> Iterator[RenderableType | str]:
    """Yield a table of a plan with its texts for a terminal; nothing if the table is empty."""
    section = table.section(plan)
    if section is None or section.table is None:
        return
    yield from build_titled_table(
        section.title, section.table.T if table.is_wide else section.table
    )
    if section.note:
        yield format_note(section.note)
    yield from section.lines


def _ended(plan: ManeuverPlan) -> str:
    if plan.problem.model.ends_with_last_maneuver:
        ended = "ended"
    else:
        ended = "converged" if plan.converged else "not converged at the end of the run,"
    return f"nominal run {ended}" if plan.scenario.flight else ended


def plan_document(picked: Picked) -> dict[str, Any]:
    """Return the JSON document of ``mgeo attitude show``, with tables as lists of rows."""
    plan = picked.plan
    tables = {
        key: to_records(each.table(plan)) for key, each in TABLES.items() if key != "worst_axis"
    }
    return {
        "solution": picked.solution,
        "answer": plan.answer,
        "uncalibrated": plan.uncalibrated(),
        "attitude_sigma_deg": plan.attitude_sigma_deg,
        "attitude_accuracy_deg": float(attitude_accuracy_deg(plan.covariance)),
        "scenario": plan.scenario.name,
        "converged": plan.converged,
        "t_end_s": plan.t_end,
        "held_until_s": plan.held_until,
        "duration_s": plan.duration,
        "trace": plan.trace,
        "design": list(plan.design),
        "limit": _limit(plan),
        "reasons": plan.reasons(),
        **tables,
    }


def _limit(plan: ManeuverPlan) -> dict[str, Any]:
    """Return the lower bound at the plan's end, or the reason for a missing bound."""
    try:
        curves = plan.problem.limit_curves
    except NoLowerBoundError as reason:
        return {"reason": str(reason)}
    least = float(curves.trace[plan.steps(plan.t_end)])
    return {
        "trace": least,
        "times": plan.trace / least,
        "worst_axis": to_records(plan.at_best()),
        "given_away": list(curves.relaxations),
    }


def write_figures(plan: ManeuverPlan, path: Path) -> None:
    """Write the figures of a plan as one HTML page."""
    html = render_report_page(f"plan, {plan.scenario.name}", list(plan_figures(plan).values()))
    write_file(path, html.encode())
