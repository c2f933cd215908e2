"""Comparison of plans with the lower bounds of trace and 1-sigma that hold for every maneuver.

The bounds are computed in `mgeo_attitude.lower_bound`.
"""

from __future__ import annotations

import math

import numpy as np

from mgeo._text import format_duration
from mgeo_attitude._typing import Floats
from mgeo_attitude.lower_bound.curves import LowerBound
from mgeo_attitude.lower_bound.samples import NoLowerBoundError
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.criteria import RequiredSigma
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import list_block_units

#: Relative tolerance for rounding errors of the filter, which the lower bound does not include.
_ROUNDING = 1e-9
#: Number of points of each curve in a figure.
_N_POINTS = 400


def find_lower_bound(problem: AttitudeManeuverProblem) -> LowerBound | None:
    """Return the lower bounds on the covariance of any maneuver, or None if none can be proved."""
    try:
        return problem.lower_bound
    except NoLowerBoundError:
        return None


def is_valid_for_monte_carlo(scenario: Scenario) -> bool:
    """Return True if the nominal lower bound also holds in Monte Carlo runs.

    The nominal lower bound does not depend on errors of the initial attitude or of the rates. The
    exceptions are gyro errors that rates make observable, scenarios that follow an earlier
    calibration, and Monte Carlo runs with random start delays or noise levels.
    """
    settings = scenario.monte_carlo
    if settings is None:
        return True
    has_nominal_model = not (settings.start_delay or settings.noise_spread)
    return has_nominal_model and scenario.prior is None and list(scenario.gyro.states()) == ["bias"]


def list_infeasible_requirements(problem: AttitudeManeuverProblem) -> list[str]:
    """List the required 1-sigmas that are below their lower bound, one line of text each.

    The line suggests how to change the scenario.
    """
    scenario, model = problem.scenario, problem.model
    if not scenario.required_sigma or not is_valid_for_monte_carlo(scenario):
        return []
    bound = find_lower_bound(problem)
    if bound is None:
        return []
    required = RequiredSigma(scenario.required_sigma).list_sigmas(model.suite.units)
    first = model.window_steps if model.rule == "trace" else 0  # Earliest step of t_end.
    lines = []
    for unit, name, max_sigma in zip(
        list_block_units(model.suite), model.suite.blocks, required, strict=True
    ):
        min_sigma = (1.0 - _ROUNDING) * float(bound.compute_sigma(name)[first:].min())
        if min_sigma > max_sigma:
            lines.append(
                f"Required 1-sigma of {unit.label}: no maneuver reaches "
                f"{max_sigma * unit.factor:.4g} {unit.unit} within "
                f"{format_duration(model.duration)}. Relax it to more than "
                f"{_round_up(min_sigma * unit.factor)} {unit.unit}, use better sensors, or allow a "
                "longer duration."
            )
    return lines


def compute_bound_curves(problem: AttitudeManeuverProblem, t_end: Floats) -> Floats:
    """Compute the lower bounds of trace and attitude 1-sigma over the convergence times of a front.

    The range starts at 0.8 times the smallest time. With Monte Carlo runs, the convergence time of
    a plan varies between runs; the curves are then the running minimum of the bounds.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
    t_end : array, shape (n,)
        Convergence times of plans [s].

    Returns
    -------
    array, shape (k, 3)
        Time [s], trace, and 1-sigma of the attitude about the worst body axis [deg]. There are no
        rows if no bound can be proved.
    """
    bound = find_lower_bound(problem) if is_valid_for_monte_carlo(problem.scenario) else None
    if bound is None:
        return np.empty((0, 3))
    ends = [0.8 * np.nanmin(t_end), np.nanmax(t_end)]
    first, last = np.searchsorted(bound.times, ends).clip(max=len(bound.times) - 1)
    indices = np.unique(np.linspace(first, last, _N_POINTS).round().astype(np.int64))
    curves = np.column_stack([bound.trace, np.degrees(bound.compute_sigma("attitude"))])
    if problem.scenario.monte_carlo:
        curves = np.minimum.accumulate(curves)
    return np.column_stack([bound.times, curves])[indices]


def _round_up(value: float) -> str:
    """Format a positive number with three significant digits, rounded up."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{math.ceil(value / unit * (1.0 - 1e-12)) * unit:.3g}"
