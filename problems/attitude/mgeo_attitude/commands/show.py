"""Output of ``mgeo attitude show``: sections for the terminal, JSON and the page of a plan."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mgeo.plugins.review import build_records
from mgeo.report.review_page import render_review_page
from mgeo.store.atomic import write_file
from mgeo.terminal import Output
from mgeo_attitude.commands.files import SelectedPlan
from mgeo_attitude.criteria.objectives import attitude_accuracy_deg
from mgeo_attitude.plan.figures import build_plan_figures
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.plan.summary import list_warnings, warn_of_late_convergence
from mgeo_attitude.plan.tables import SECTIONS, build_review, build_sections
from mgeo_attitude.plan_sections import SECTION_CONTENTS, SUMMARY

if TYPE_CHECKING:
    from mgeo_attitude.documents import PlanSummary


def print_plan(selected: SelectedPlan, keys: Collection[str], output: Output) -> None:
    """Print the requested sections about a plan.

    Warnings follow the summary if it is among the sections.

    Parameters
    ----------
    selected : SelectedPlan
    keys : collection of str
        Names of the sections.
    output : Output
    """
    plan = selected.plan
    name = f"{selected.name[0].upper()}{selected.name[1:]}"
    sections = build_sections(plan, keys)
    if SUMMARY in keys:
        summary, *sections = sections
        title = f"{name}, scenario {plan.scenario.name}"
        output.print_sections(replace(summary, title=title))
        output.print_warnings([*list_warnings(plan), *warn_of_late_convergence(plan)])
        if sections:
            output.print("")
    output.print_sections(*sections)
    others = {key: text for key, text in SECTION_CONTENTS.items() if key not in keys}
    if SUMMARY in keys and others:
        output.print("")
        output.print_title("Other sections (--section NAME, or --all)")
        output.print_pairs(others)


def build_plan_document(selected: SelectedPlan, keys: Collection[str]) -> dict[str, Any]:
    """Return the JSON output of ``mgeo attitude show`` as a dict keyed by section.

    The summary is a dict, and each table is a list of dicts, one per row.
    """
    plan = selected.plan
    tables = {key: build_records(each.table(plan)) for key, each in SECTIONS.items() if key in keys}
    return ({SUMMARY: _build_summary(selected)} if SUMMARY in keys else {}) | tables


def _build_summary(selected: SelectedPlan) -> PlanSummary:
    plan, attitude = selected.plan, selected.plan.accuracy.iloc[0]
    (monte_carlo_t_end,) = plan.view.monte_carlo_t_end
    return {
        "solution": selected.solution,
        "scenario": plan.scenario.name,
        "design": list(plan.design),
        "converged": plan.converged,
        "t_end_s": plan.t_end,
        "t_end_90_percent_of_runs_s": monte_carlo_t_end,
        "hold_end_s": plan.hold_end,
        "duration_s": plan.duration,
        "trace": plan.trace,
        "attitude_1sigma_deg": plan.attitude_sigma_deg,
        "attitude_1sigma_any_axis_deg": float(attitude_accuracy_deg(plan.covariance)),
        "attitude_1sigma_90_percent_of_runs_deg": attitude["90 % of runs"],
        "attitude_lower_bound_deg": attitude.get("lower bound"),
        "constraints_satisfied": not plan.list_violations(),
        "uncalibrated_errors": plan.list_uncalibrated_errors(),
        "warnings": [*list_warnings(plan), *warn_of_late_convergence(plan)],
    }


def write_plan_page(plan: ManeuverPlan, path: Path) -> None:
    """Write the HTML page of a plan."""
    html = render_review_page(build_review(plan), build_plan_figures(plan))
    write_file(path, html.encode())
