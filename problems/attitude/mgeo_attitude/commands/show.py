"""``mgeo attitude show``."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import pandas as pd
from rich.table import Table
from rich.text import Text

from mgeo.cli.output import Output, rows
from mgeo.figures.page import report_page
from mgeo.store.atomic import write_file
from mgeo.terminal import note, plain, titled
from mgeo_attitude.bound.samples import NoLimit
from mgeo_attitude.commands.files import Picked
from mgeo_attitude.criteria.objectives import attitude_accuracy_deg
from mgeo_attitude.plan.figures import plan_figures
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.view.plans import MOST_SAMPLES


def print_plan(picked: Picked, output: Output) -> None:
    """Print everything that fits a terminal."""
    plan = picked.plan
    ended = "converged" if plan.history.converged else "not converged at the end of the run,"
    if plan.problem.model.ends_by_design:
        ended = "ended"
    if plan.scenario.flight:
        ended = f"flown exactly, {ended}"
    orbits = plan.t_end / plan.scenario.orbit.period
    constraints = plan.constraints()
    kept = constraints["kept"].map({True: "kept", False: "violated"})
    output.print(
        plain(picked.answer, "bold"),
        *picked.doubts(),
        f"scenario {plan.scenario.name}: {ended} at {plan.t_end:.6g} s ({orbits:.3f} orbits), "
        f"trace {plan.trace:.4g}",
        *plan.limit(),
        *plan.late(),
        *_slew_back(plan),
        *(titled("Constraints", constraints.assign(kept=kept)) if len(kept) else ()),
        *(_over_flights(plan) if len(kept) else ()),
        *promised(plan),
        *titled("Timeline", _timeline(plan).T, digits=6),
        *titled(f"Predicted 1-sigma{_of_flights(plan)}", plan.accuracy()),
        *([note("all below: flown exactly")] if plan.scenario.turned_by_coils else []),
        *_at_best(plan),
        plain("\nWhy it is no smaller", "bold"),
        *plan.reasons(),
        *titled("Error budget, 1-sigma of the worst body axis", plan.budget(), digits=3),
        note("with the filter's gains: squares add up to that of all, 1-sigmas do not"),
        *titled("What would help, 1-sigma of the worst body axis", plan.remedies(), digits=3),
        note("each by a run of the filter; limits are not looked at"),
        *titled("How long sensors measured", plan.sensor_use()),
        *titled("What each phase bought", _contributions(plan).T),
        note("trace and worst body axis at its end"),
        *titled("Least observable directions", plan.least_observable(5).iloc[:, 1::-1], digits=3),
        note("remaining: 1-sigma along it over the initial one; 1 is nothing learned"),
        *titled(f"Beside plans that need no optimizer, after {plan.t_end:.6g} s", _others(plan).T),
        note("1-sigma of the worst body axis; t_end: when each by itself converges"),
    )


def _of_flights(plan: ManeuverPlan) -> str:
    """What 1-sigmas are of, if not of the plan flown exactly; see `Plans.sigma`."""
    return ", of Monte Carlo samples" if plan.scenario.turned_by_coils else ""


def _slew_back(plan: ManeuverPlan) -> list[str]:
    if plan.slew_back is None:
        return []
    line, duration = f"slew back until {plan.duration:.6g} s", plan.scenario.duration
    if plan.duration <= duration:
        return [line]
    return [
        f"{line}, {plan.duration - duration:.6g} s after duration = {duration:.6g} s: that limits "
        "the time to converge, it is no window"
    ]


def _at_best(plan: ManeuverPlan) -> tuple[Text | Table, ...]:
    try:
        return titled("Worst axis, and what no maneuver can beat", plan.at_best())
    except NoLimit:  # which is told above
        return ()


def _over_flights(plan: ManeuverPlan) -> list[Text]:
    """What values of constraints are, of a plan that is judged over flights."""
    errors = plan.scenario.flight
    if errors is None:
        return []
    share = f"{errors.kept:.0%} of {errors.count} flights"
    return [note(f"values until t_end: what {share} keep; all other tables: flown exactly")]


def promised(plan: ManeuverPlan) -> tuple[Text | Table, ...]:
    """What is promised and kept, as a table for people."""
    said = f"promised: by the plan; kept: by {MOST_SAMPLES} of 200, of the errors in [flight]"
    if math.inf in plan.over_flights:
        longest = plan.problem.model.longest
        said += f"; a t_end of {longest:.6g} s is that of samples that do not converge"
    return *titled("Objectives, and over Monte Carlo samples", plan.promises()), note(said)


def plan_document(picked: Picked) -> dict[str, Any]:
    """What ``mgeo attitude show`` tells of a plan; tables as lists of rows."""
    plan = picked.plan
    return {
        "solution": picked.solution,
        "answer": plan.answer,
        "uncalibrated": plan.uncalibrated(),
        "attitude_sigma_deg": plan.attitude_sigma_deg,
        "attitude_accuracy_deg": float(attitude_accuracy_deg(plan.history.covariance)),
        "scenario": plan.scenario.name,
        "converged": bool(plan.history.converged),
        "t_end_s": plan.t_end,
        "held_until_s": plan.held_until,
        "duration_s": plan.duration,
        "trace": plan.trace,
        "design": list(plan.design),
        "constraints": rows(plan.constraints()),
        "promises": rows(plan.promises()),
        "timeline": rows(plan.timeline()),
        "accuracy": rows(plan.accuracy()),
        "limit": _limit(plan),
        "reasons": plan.reasons(),
        "budget": rows(plan.budget()),
        "remedies": rows(plan.remedies()),
        "sensor_use": rows(plan.sensor_use()),
        "contributions": rows(plan.contributions()),
        "least_observable": rows(plan.least_observable(5)),
        "comparison": rows(plan.compare()),
    }


def _limit(plan: ManeuverPlan) -> dict[str, Any]:
    """What no maneuver can beat at the plan's end, or the reason why that is not known."""
    try:
        found = plan.problem.limit_curves
    except NoLimit as reason:
        return {"reason": str(reason)}
    least = float(found.trace[plan.steps(plan.t_end)])
    return {
        "trace": least,
        "times": plan.trace / least,
        "worst_axis": rows(plan.at_best()),
        "given_away": list(found.given_away),
    }


def write_figures(plan: ManeuverPlan, path: Path) -> None:
    """Write `plan_figures` as one page."""
    html = report_page(f"plan, {plan.scenario.name}", list(plan_figures(plan).values()))
    write_file(path, html.encode())


def _timeline(plan: ManeuverPlan) -> pd.DataFrame:
    table = plan.timeline().set_index("phase")
    rates = [f"rate {axis} [deg/s]" for axis in "xyz"]
    attitude = [f"end q{part}" for part in "123c"]
    names = ["start UTC", "start [s]", "duration [s]", *rates, "swept [deg]", *attitude]
    return table[names]


def _contributions(plan: ManeuverPlan) -> pd.DataFrame:
    table = plan.contributions()
    axes = table.iloc[:, 3:].T.groupby(lambda name: re.sub(" [xyz] ", " ", name), sort=False)
    return table.iloc[:, :3].join(axes.max().T)


def _others(plan: ManeuverPlan) -> pd.DataFrame:
    table = plan.compare()
    short = {name: name.replace(" 1-sigma [", " [") for name in table.columns}
    return table.rename(columns=short | {"times the first [-]": "times the plan's [-]"})
