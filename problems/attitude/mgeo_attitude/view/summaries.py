"""Summaries of maneuver plans: one line of text per plan, and tables with one row per plan."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mgeo._text import format_duration, format_two_digits
from mgeo.evaluation.dominance import find_nondominated
from mgeo_attitude._typing import Floats
from mgeo_attitude.criteria.objectives import OBJECTIVES, PAPER_OBJECTIVES
from mgeo_attitude.lower_bound.samples import NoLowerBoundError
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER, get_durations
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import Suite, list_block_units
from mgeo_attitude.view.plans import MONTE_CARLO_SHARE, MONTE_CARLO_SHARE_TEXT, Plans

#: Summary of a plan whose covariance was lost.
COVARIANCE_LOST = "The covariance of the filter lost positivity"
#: Name of the column with the ratio of the trace to its lower bound.
BOUND_RATIO_COLUMN = "trace / lower bound [-]"


def summarize_plans(plans: Plans) -> list[str]:
    """Return a one-line summary of each plan with its end and its predicted 1-sigmas.

    The 1-sigmas are those of the attitude and of each bias about the worst body axis. If the design
    fixes t_end, the line has the attitude 1-sigma that 90 % of Monte Carlo runs do not exceed.

    Returns
    -------
    list of str
    """
    suite, is_monte_carlo = plans.problem.model.suite, plans.problem.scenario.is_magnetorquer_driven
    lines = [
        f"{end}: {_describe_sigma(suite, sigma, is_monte_carlo)}"
        if math.isfinite(t_end)
        else COVARIANCE_LOST
        for end, sigma, t_end in zip(
            describe_ends(plans), plans.sigma, plans.nominal.t_end, strict=True
        )
    ]
    if not plans.problem.model.ends_with_last_maneuver:
        return lines
    return [
        f"{line}; attitude {format_two_digits(sigma)} deg or less in {MONTE_CARLO_SHARE_TEXT}"
        if math.isfinite(sigma)
        else line
        for line, sigma in zip(lines, plans.monte_carlo_sigma_deg, strict=True)
    ]


def describe_ends(plans: Plans) -> list[str]:
    """Return one sentence per plan, without a period, on the time at which it ends or converges.

    The time of a robust plan is its objective, the time within which the requested share of the
    Monte Carlo runs of the search converge.
    """
    errors = plans.problem.scenario.monte_carlo
    run_times, share = plans.monte_carlo_t_end, MONTE_CARLO_SHARE
    if errors is not None and not errors.mean:
        run_times, share = plans.robust_t_end, errors.quantile
    runs = f"{100.0 * share:g} % of Monte Carlo runs"
    times = plans.nominal.t_end, run_times, plans.end_times
    return [
        _describe_end(plans, runs, *row)
        for row in zip(*(each.tolist() for each in times), strict=True)
    ]


def _describe_end(plans: Plans, runs: str, t_end: float, run_time: float, end: float) -> str:
    if not math.isfinite(t_end):
        return COVARIANCE_LOST
    model, scenario = plans.problem.model, plans.problem.scenario
    after = format_duration(t_end)
    is_converged = t_end < model.nonconvergence_time
    converges, converge = "converges", "converge"
    if model.rule == "required":
        converges, converge = "ends with satisfied requirements", "satisfy the requirements"
    nominal = (
        f"{converges} after {after}" if is_converged else f"does not {converge} within {after}"
    )
    within = f"within {format_duration(run_time)}" if math.isfinite(run_time) else ""
    if model.ends_with_last_maneuver:
        text = f"Ends after {after}"
    elif math.isinf(run_time):
        text = f"Fewer than {runs} {converge}; the nominal run {nominal}"
    elif within and (scenario.monte_carlo or scenario.is_magnetorquer_driven):
        text = f"{converges.capitalize()} {within} in {runs}"
    elif not within or run_time == t_end:
        text = nominal.capitalize()
    elif not is_converged:
        text = f"{converges.capitalize()} {within} in {runs}; the nominal run {nominal}"
    else:
        text = f"{nominal.capitalize()}, in {runs} {within}"
    if scenario.maneuvers.slew_back and math.isfinite(end):
        text += f"; the slew back ends after {format_duration(end)}"
    return text


def _describe_sigma(suite: Suite, sigma: Floats, is_monte_carlo: bool) -> str:
    if not np.isfinite(sigma).all():  # One run with a lost covariance makes the mean undefined.
        return f"{COVARIANCE_LOST} in Monte Carlo runs"
    parts, worsts = [], sigma.reshape(-1, 3).max(axis=1)
    for block, name, worst in zip(list_block_units(suite), suite.blocks, worsts, strict=True):
        if name == "attitude" or name.endswith(".bias"):
            parts.append(f"{block.label} {format_two_digits(worst * block.factor)} {block.unit}")
    source = " of Monte Carlo runs" if is_monte_carlo else ""
    return f"predicted {', '.join(parts)} (1-sigma{source}, worst body axis)"


def format_nominal_suffix(scenario: Scenario) -> str:
    """Return the title suffix ", nominal" if there are Monte Carlo results, otherwise an empty
    string.
    """
    return ", nominal" if scenario.monte_carlo or scenario.is_magnetorquer_driven else ""


def build_plan_table(plans: Plans) -> pd.DataFrame:
    """Return a table of nominal and Monte Carlo results, with one row per plan.

    The table has the columns of `compute_quick_metrics` and, for each objective, its 0.9-quantile
    over Monte Carlo runs (see `Plans.compare_with_monte_carlo`). If the scenario has Monte Carlo
    runs, the predicted objectives and these quantiles come first. With magnetorquers, the 1-sigmas
    are those of `Plans.sigma`.

    Returns
    -------
    DataFrame
        One row per plan.
    """
    table, robustness = compute_quick_metrics(plans), plans.compare_with_monte_carlo()
    if plans.problem.scenario.is_magnetorquer_driven:  # No run is nominal.
        table = table.assign(**compute_worst_axes(plans.problem.model.suite, plans.sigma))
    if not plans.problem.scenario.monte_carlo:  # The predicted values are the nominal ones.
        return table.join(robustness.filter(regex="^Monte Carlo (?!/)"))
    return robustness.filter(regex="^(predicted|Monte Carlo) (?!/)").join(table)


def compute_quick_metrics(plans: Plans) -> pd.DataFrame:
    """Compute a table of nominal results, with one row per plan.

    If the scenario has Monte Carlo runs, the names of objectives mark them as nominal. Objectives
    and 1-sigmas are NaN for a design whose covariance lost positivity.

    Returns
    -------
    DataFrame
        The paper's objectives; ``t_end [orbits]``; ``trace / lower bound [-]``, if a bound can be
        proved; ``maneuver time [s]``, the sum of all durations;
        ``slew-back end [s]``, if there is a slew back, possibly after the scenario's duration;
        ``start UTC``, if the start is free; one text per maneuver with rates about body x / y / z
        [deg/s] and duration [s]; and the predicted 1-sigma at t_end of the worst body axis of each
        3-vector of the error state.

    Raises
    ------
    ValueError
        If a design is invalid.
    """
    problem, designs, result = plans.problem, plans.X, plans.nominal
    variances = np.diagonal(result.covariance, axis1=1, axis2=2)
    sigma = np.sqrt(np.where(np.isnan(result.t_end)[:, None], np.nan, variances))
    t_end_name, trace_name = (OBJECTIVES[name].label for name in PAPER_OBJECTIVES)
    durations = get_durations(designs)
    columns: dict[str, Any] = {
        t_end_name: result.t_end,
        "t_end [orbits]": result.t_end / problem.scenario.orbit.period,
        trace_name: result.trace,
    }
    with suppress(NoLowerBoundError):
        columns[BOUND_RATIO_COLUMN] = result.trace / problem.lower_bound.evaluate_trace(
            result.t_end
        )
    columns["maneuver time [s]"] = durations.sum(axis=1)
    if problem.scenario.maneuvers.slew_back:
        columns["slew-back end [s]"] = plans.end_times
    texts = [format_maneuvers(x) for x in designs]
    for m in range(durations.shape[1]):
        name = f"maneuver {m + 1}: x / y / z [deg/s] for d [s]"
        columns[name] = [text[m] for text in texts]
    table = pd.DataFrame(columns | compute_worst_axes(problem.model.suite, sigma))
    if not problem.scenario.monte_carlo:
        return table
    nominal_names = {
        name: f"{name}, nominal" for name in (t_end_name, trace_name, BOUND_RATIO_COLUMN)
    }
    return table.rename(columns=nominal_names)


def compute_worst_axes(suite: Suite, sigma: Floats) -> dict[str, Any]:
    """Compute the worst-axis 1-sigma of each 3-vector in the state, as table columns.

    Parameters
    ----------
    suite : Suite
    sigma : array, shape (n, n_states)
        1-sigma of every state in the filter's units.

    Returns
    -------
    dict of str to array, shape (n,)
        1-sigmas in display units. The column name contains the unit.
    """
    blocks = list_block_units(suite)
    worst = sigma.reshape(len(sigma), len(blocks), 3).max(axis=2)
    return {
        f"{block.label} 1-sigma [{block.unit}]": values * block.factor
        for block, values in zip(blocks, worst.T, strict=True)
    }


def count_front_points(scenario: Scenario, F: ArrayLike) -> dict[str, float]:
    """Count the nondominated points that converge within the first orbit and after it.

    The paper's Table 3 lists these counts for runs of two orbits. In a longer run, the second count
    includes all later orbits.

    Parameters
    ----------
    scenario : Scenario
    F : array_like, shape (n, 2)
        t_end [s] and trace of each point.

    Returns
    -------
    dict of str to float
        Counts with the keys ``points, first orbit`` and ``points, second orbit``.
    """
    table = np.asarray(F, dtype=float)
    t_end = table[find_nondominated(table), 0]
    first = int((t_end <= scenario.orbit.period).sum())
    return {"points, first orbit": first, "points, second orbit": len(t_end) - first}


def format_maneuvers(x: Floats) -> list[str]:
    """Format each maneuver as ``x / y / z for duration``, in deg/s and s."""
    maneuvers = x[: len(x) - len(x) % VARIABLES_PER_MANEUVER]
    return [
        f"{' / '.join(f'{rate:+.3f}' for rate in rates)} for {duration:.1f}"
        for *rates, duration in maneuvers.reshape(-1, VARIABLES_PER_MANEUVER)
    ]
