"""Output of ``mgeo attitude show``: tables for the terminal, JSON and figures."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.console import RenderableType

from mgeo.figures.page import render_report_page
from mgeo.store.atomic import write_file
from mgeo.terminal import Output, build_titled_table, escape_text, format_note, to_records
from mgeo_attitude.commands.files import SelectedPlan
from mgeo_attitude.criteria.objectives import attitude_accuracy_deg
from mgeo_attitude.lower_bound.samples import NoLowerBoundError
from mgeo_attitude.plan.figures import build_plan_figures
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.plan.tables import TABLES, PlanTable


def print_plan(selected: SelectedPlan, output: Output) -> None:
    """Print the summary of a plan, its warnings and all its tables to the terminal."""
    plan = selected.plan
    orbits = plan.t_end / plan.scenario.orbit.period
    output.print(
        escape_text(selected.summary, "bold"),
        *selected.list_warnings(),
        f"scenario {plan.scenario.name}: {_describe_end(plan)} at {plan.t_end:.6g} s ({orbits:.3f} "
        f"orbits), trace {plan.trace:.4g}",
        *plan.describe_lower_bound(),
        *plan.describe_hold(),
    )
    for table in TABLES.values():
        output.print(*render_table(table, plan))


def render_table(table: PlanTable, plan: ManeuverPlan) -> Iterator[RenderableType | str]:
    """Yield the printable parts of a table about a plan: title, rows, note and lines of text.

    Nothing is yielded if the table has no rows.
    """
    section = table.build_section(plan)
    if section is None or section.table is None:
        return
    yield from build_titled_table(
        section.title, section.table.T if table.is_wide else section.table
    )
    if section.note:
        yield format_note(section.note)
    yield from section.lines


def _describe_end(plan: ManeuverPlan) -> str:
    if plan.problem.model.ends_with_last_maneuver:
        state = "ended"
    else:
        state = "converged" if plan.converged else "not converged at the end of the run,"
    return f"nominal run {state}" if plan.scenario.monte_carlo else state


def build_plan_document(selected: SelectedPlan) -> dict[str, Any]:
    """Return the JSON output of ``mgeo attitude show`` as a dict. Each table is a list of dicts,
    one per row.
    """
    plan = selected.plan
    tables = {
        key: to_records(each.table(plan)) for key, each in TABLES.items() if key != "worst_axis"
    }
    return {
        "solution": selected.solution,
        "summary": plan.summary,
        "uncalibrated_errors": plan.list_uncalibrated_errors(),
        "attitude_sigma_deg": plan.attitude_sigma_deg,
        "attitude_accuracy_deg": float(attitude_accuracy_deg(plan.covariance)),
        "scenario": plan.scenario.name,
        "converged": plan.converged,
        "t_end_s": plan.t_end,
        "hold_end_s": plan.hold_end,
        "duration_s": plan.duration,
        "trace": plan.trace,
        "design": list(plan.design),
        "lower_bound": _describe_lower_bound(plan),
        "error_drivers": plan.describe_error_drivers(),
        **tables,
    }


def _describe_lower_bound(plan: ManeuverPlan) -> dict[str, Any]:
    try:
        bound = plan.problem.lower_bound
    except NoLowerBoundError as reason:
        return {"reason": str(reason)}
    min_trace = float(bound.trace[plan.to_steps(plan.t_end)])
    return {
        "trace": min_trace,
        "ratio": plan.trace / min_trace,
        "worst_axis": to_records(plan.compare_with_lower_bound()),
        "relaxations": list(bound.relaxations),
    }


def write_figures(plan: ManeuverPlan, path: Path) -> None:
    html = render_report_page(
        f"plan, {plan.scenario.name}", list(build_plan_figures(plan).values())
    )
    write_file(path, html.encode())
