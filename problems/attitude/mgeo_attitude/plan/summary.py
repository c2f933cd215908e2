"""Summary of one plan in sentences, and warnings with what to do."""

from __future__ import annotations

import math

from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.view.summaries import COVARIANCE_LOST, format_duration


def describe_plan(plan: ManeuverPlan) -> list[str]:
    """Return sentences on the convergence time, the attitude accuracy and the constraints of a
    plan.
    """
    if math.isnan(plan.view.nominal.t_end[0]):
        return [f"{COVARIANCE_LOST[0].upper()}{COVARIANCE_LOST[1:]}."]
    return [
        " ".join([_describe_end(plan), *_describe_accuracy(plan)]),
        " ".join([*_describe_time_after_convergence(plan), _describe_constraints(plan)]),
    ]


def _describe_end(plan: ManeuverPlan) -> str:
    time = format_duration(plan.t_end)
    if plan.problem.model.ends_with_last_maneuver:
        return f"The maneuvers end after {time}."
    (monte_carlo_t_end,) = plan.view.monte_carlo_t_end
    if not plan.converged:
        return f"The filter does not converge within {time}."
    if math.isnan(monte_carlo_t_end):
        return f"The filter converges after {time}."
    if math.isinf(monte_carlo_t_end):
        return (
            f"The filter converges after {time} in the nominal run. Fewer than 90 % of Monte Carlo "
            "runs converge."
        )
    robust_time = format_duration(monte_carlo_t_end)
    return (
        f"The filter converges after {time}, and in 90 % of Monte Carlo runs within {robust_time}."
    )


def _describe_accuracy(plan: ManeuverPlan) -> list[str]:
    attitude = plan.accuracy.iloc[0]
    sentences = [
        f"The predicted attitude accuracy is then {attitude['predicted']:.2g} deg (1-sigma, worst "
        f"body axis), and at most {attitude['90 % of runs']:.2g} deg in 90 % of Monte Carlo runs."
    ]
    if "ratio" in attitude:
        sentences.append(
            f"The predicted value is {attitude['ratio']:.3g} times the lower bound for any "
            "maneuver of this duration."
        )
    return sentences


def _describe_time_after_convergence(plan: ManeuverPlan) -> list[str]:
    hold, slew_back = [], []
    if plan.hold_end > plan.t_end:
        hold = [
            f"The last rates are held until {format_duration(plan.hold_end)} for runs that "
            "converge later."
        ]
    if plan.slew_back:
        end = format_duration(plan.duration)
        slew_back = [f"The slew back to the initial attitude ends after {end}."]
    return hold + slew_back


def _describe_constraints(plan: ManeuverPlan) -> str:
    table = plan.build_constraint_table()
    n, violated = len(table), table.index[~table["satisfied"].astype(bool)]
    if not n:
        return "The scenario has no constraints."
    if len(violated):
        return f"{len(violated)} of {n} constraints are violated: {', '.join(violated)}."
    return "The constraint is satisfied." if n == 1 else f"All {n} constraints are satisfied."


def list_warnings(plan: ManeuverPlan) -> list[str]:
    """Return one sentence for each warning: calibration parameters that the plan hardly improves,
    and modeling assumptions.
    """
    errors = plan.list_uncalibrated_errors()
    lines = []
    if errors:
        lines.append(
            f"More than half of the initial 1-sigma remains of {', '.join(errors)}. Plans that "
            "converge later reduce these errors further."
        )
    return [*lines, *plan.scenario.assumptions]


def warn_of_late_convergence(plan: ManeuverPlan) -> list[str]:
    """Return a list with one sentence if a plan without robust objectives converges later in Monte
    Carlo runs than in the nominal run, otherwise an empty list.
    """
    (monte_carlo_t_end,) = plan.view.monte_carlo_t_end
    if plan.scenario.monte_carlo or not monte_carlo_t_end > plan.t_end:
        return []
    event = "slew back begins" if plan.slew_back else "commands end"
    time = format_duration(plan.t_end)
    text = f"The {event} after {time}, before 90 % of Monte Carlo runs converge."
    # With magnetorquers, the body rotates freely after the last maneuver.
    is_free = plan.slew_back or plan.scenario.is_magnetorquer_driven
    if is_free or math.isinf(monte_carlo_t_end):
        return [f"{text} Search for a robust plan with mgeo solve --robust."]
    return [
        f"{text} Hold the last rates until {format_duration(monte_carlo_t_end)}, or search for a "
        "robust plan with mgeo solve --robust."
    ]
