"""Summary of one plan in sentences, and warnings with what to do."""

from __future__ import annotations

import math

from mgeo._text import format_duration
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.view.summaries import describe_ends


def describe_plan(plan: ManeuverPlan) -> list[str]:
    """Summarize the convergence time, accuracy and constraints of a plan in a few sentences."""
    (end,) = describe_ends(plan.view)
    first = [f"{end}.", *_describe_accuracy(plan)]
    second = [*_describe_hold(plan), *_describe_constraints(plan)]
    return [" ".join(sentences) for sentences in (first, second) if sentences]


def _describe_accuracy(plan: ManeuverPlan) -> list[str]:
    attitude = plan.accuracy.iloc[0]
    in_runs = f"{attitude['90 % of runs']:.2g} deg or less"
    sentences = [
        f"The predicted attitude accuracy is {attitude['predicted']:.2g} deg (1-sigma, worst "
        f"body axis). In 90 % of Monte Carlo runs, the 1-sigma is {in_runs}."
    ]
    if "ratio" in attitude:
        sentences.append(
            f"The predicted 1-sigma is {attitude['ratio']:.3g} times the lower bound for any "
            "maneuver of this duration."
        )
    return sentences


def _describe_hold(plan: ManeuverPlan) -> list[str]:
    if plan.hold_end <= plan.t_end:
        return []
    time = format_duration(plan.hold_end)
    return [f"The last rates are held until {time}, because some runs converge that late."]


def _describe_constraints(plan: ManeuverPlan) -> list[str]:
    table = plan.build_constraint_table()
    n, violated = len(table), table.index[~table["satisfied"].astype(bool)]
    if len(violated):
        return [f"{len(violated)} of {n} constraints are violated: {', '.join(violated)}."]
    satisfied = "The constraint is satisfied." if n == 1 else f"All {n} constraints are satisfied."
    return [satisfied] if n else []


def list_warnings(plan: ManeuverPlan) -> list[str]:
    """Return warnings about a plan, one sentence each.

    The warnings concern errors that the plan hardly reduces, and modeling assumptions.
    """
    errors = plan.list_uncalibrated_errors()
    lines = []
    if errors:
        lines.append(
            f"More than half of the initial 1-sigma remains of {', '.join(errors)}. "
            "Longer plans reduce these errors further."
        )
    return [*lines, *plan.scenario.assumptions]


def warn_of_final_rate(plan: ManeuverPlan) -> list[str]:
    """Return a warning if a plan ends with a body rate, without a slew back."""
    rate = math.hypot(*plan.phases[-1].commanded_deg_s)
    if plan.slew_back or plan.scenario.is_magnetorquer_driven or not rate:
        return []
    return [
        f"The plan ends with a body rate of {rate:.2f} deg/s (norm of the three axes). Set "
        "maneuvers.slew_back = true in the scenario file for a return to the initial pointing."
    ]


def warn_of_late_convergence(plan: ManeuverPlan) -> list[str]:
    """Return a warning if a plan converges later in Monte Carlo runs than in its nominal run.

    The list is empty if no warning is needed, or if the objectives of the plan are robust.
    """
    (monte_carlo_t_end,) = plan.view.monte_carlo_t_end
    if plan.scenario.monte_carlo or not monte_carlo_t_end > plan.t_end:
        return []
    event = "slew back begins" if plan.slew_back else "commands end"
    time = format_duration(plan.t_end)
    verb = "satisfy required_sigma" if plan.problem.model.rule == "required" else "converge"
    text = f"The {event} after {time}, before 90 % of Monte Carlo runs {verb}."
    # With magnetorquers, the body rotates freely after the last maneuver.
    is_free = plan.slew_back or plan.scenario.is_magnetorquer_driven
    if is_free or math.isinf(monte_carlo_t_end):
        return [f"{text} Search for a robust plan with mgeo solve --robust."]
    return [
        f"{text} Hold the last rates until {format_duration(monte_carlo_t_end)}, or search for a "
        "robust plan with mgeo solve --robust."
    ]
