"""Comparison of plans with the lower bound of trace and 1-sigmas; see `mgeo_attitude.lower_bound`."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pandas as pd

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.history import FilterHistory
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.lower_bound.curves import LowerBound
from mgeo_attitude.lower_bound.samples import NoLowerBoundError
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.criteria import RequiredSigma
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.view.plans import Plans
from mgeo_attitude.view.summaries import format_duration

#: Relative tolerance for the filter's rounding errors, which the bound does not include.
_ROUNDING = 1e-9
#: Number of points of a curve.
_N_POINTS = 400


def find_lower_bound(problem: AttitudeManeuverProblem) -> LowerBound | None:
    """Return the lower bound of nominal plans, or None if no bound is proved."""
    try:
        return problem.lower_bound
    except NoLowerBoundError:
        return None


def is_valid_for_monte_carlo(scenario: Scenario) -> bool:
    """Return whether the nominal lower bound also holds for each Monte Carlo run.

    The bound does not depend on errors of the initial attitude or of the rates, except with gyro
    errors that rates make observable, and after a previous calibration.
    """
    flight = scenario.monte_carlo
    if flight is None:
        return True
    same = not (flight.start_delay or flight.noise_spread) and scenario.prior is None
    return same and list(scenario.gyro.states()) == ["bias"]


def list_infeasible_requirements(problem: AttitudeManeuverProblem) -> list[str]:
    """Return a line for each required 1-sigma that is below its lower bound."""
    scenario, model = problem.scenario, problem.model
    if not scenario.required_sigma or not is_valid_for_monte_carlo(scenario):
        return []
    curves = find_lower_bound(problem)
    if curves is None:
        return []
    required = RequiredSigma(scenario.required_sigma).list_sigmas(model.suite.units)
    first = model.window_steps if model.rule == "trace" else 0  # earliest step of t_end
    lines = []
    for unit, name, greatest in zip(
        list_block_units(model.suite), model.suite.blocks, required, strict=True
    ):
        least = (1.0 - _ROUNDING) * float(curves.compute_sigma(name)[first:].min())
        if least > greatest:
            lines.append(
                f"required 1-sigma of {unit.label}: {greatest * unit.factor:.4g} {unit.unit} cannot"
                f" be reached within {format_duration(model.duration)} by any maneuver: relax it to more than "
                f"{_round_up(least * unit.factor)} {unit.unit}, take better sensors, or a longer "
                "duration"
            )
    return lines


def summarize_lower_bound(plans: Plans, sample: Plans, sample_label: str) -> list[str]:
    """Return a line that compares the traces of nominal plans with the lower bound.

    The line covers the default solution of the front and the median of the plans `sample`.
    """
    from mgeo.runs.summary import select_default_solution

    problem = plans.problem
    try:
        curves = problem.lower_bound
    except NoLowerBoundError as reason:
        return [f"no lower bound of the trace: {reason}"]
    ratios = sample.nominal.trace / curves.evaluate_trace(sample.nominal.t_end)
    rows = np.flatnonzero(np.isfinite(plans.F).all(axis=1))
    if not len(rows) or np.isnan(ratios).all():
        return []
    row = int(rows[select_default_solution(problem, plans.F[rows]).row])
    shown = plans.select([row]).nominal
    (least,) = curves.evaluate_trace(shown.t_end)
    return [
        f"the lower bound of the trace after {format_duration(shown.t_end[0])} is {least:.3g}: solution {row} "
        f"has {shown.trace[0] / least:.2f} times its bound; the median of {sample_label} is "
        f"{np.nanmedian(ratios):.2f} times"
    ]


def compute_bound_curves(problem: AttitudeManeuverProblem, t_end: Floats) -> Floats:
    """Return the lower bound over the range of `t_end`, shape (k, 3).

    The range starts at 0.8 times the smallest `t_end`. For problems with Monte Carlo runs, whose
    times vary, the curves are the running minimum of the bound.

    Returns
    -------
    array, shape (k, 3)
        Time [s], trace, and 1-sigma of the attitude about the worst body axis [deg]; no rows if no
        bound is proved.
    """
    found = find_lower_bound(problem) if is_valid_for_monte_carlo(problem.scenario) else None
    if found is None:
        return np.empty((0, 3))
    ends = [0.8 * np.nanmin(t_end), np.nanmax(t_end)]
    first, last = np.searchsorted(found.times, ends).clip(max=len(found.times) - 1)
    shown = np.unique(np.linspace(first, last, _N_POINTS).round().astype(np.int64))
    curves = np.column_stack([found.trace, np.degrees(found.compute_sigma("attitude"))])
    if problem.scenario.monte_carlo:
        curves = np.minimum.accumulate(curves)
    return np.column_stack([found.times, curves])[shown]


def compare_with_lower_bound(
    model: FilterModel, bound: LowerBound, history: FilterHistory
) -> pd.DataFrame:
    """Compare the worst axis of each 3-vector of the state with the lower bound at a plan's end.

    Returns
    -------
    DataFrame
        One row per 3-vector, with columns ``unit``, ``predicted``, ``at best`` (the lower bound)
        and ``predicted / at best [-]``.
    """
    step = round(history.t_end / model.step)
    units = list_block_units(model.suite)
    factors = np.array([unit.factor for unit in units])
    worst = history.sigma[-1].reshape(-1, 3).max(axis=1)
    least = np.array([bound.compute_sigma(name)[step] for name in model.suite.blocks])
    return pd.DataFrame(
        {
            "unit": [unit.unit for unit in units],
            "predicted": worst * factors,
            "lower bound": least * factors,
            "predicted / lower bound [-]": worst / least,
        },
        index=pd.Index([unit.label for unit in units], name="error"),
    )


def describe_lower_bound(bound: LowerBound, t_end: float, trace: float) -> Iterator[str]:
    """Yield lines on a plan's trace relative to the lower bound, and on the bound's relaxations."""
    (least,) = bound.evaluate_trace(np.array([t_end]))
    yield (
        f"the trace is {trace / least:.2f} times its lower bound, which is {least:.3g} after "
        f"{format_duration(t_end)}"
    )
    if bound.relaxations:
        yield f"relaxation of the lower bound: {'; '.join(bound.relaxations)}"


def _round_up(value: float) -> str:
    unit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{math.ceil(value / unit * (1.0 - 1e-12)) * unit:.3g}"
