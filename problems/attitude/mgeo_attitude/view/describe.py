"""Plans in an engineer's terms: what each is worth in one line, and as a table."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mgeo.evaluation.dominance import nondominated
from mgeo_attitude._typing import Floats
from mgeo_attitude.bound.samples import NoLimit
from mgeo_attitude.criteria.objectives import OBJECTIVES, PAPER
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER, durations_of
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import Suite, block_units
from mgeo_attitude.view.plans import MOST_SAMPLES, Plans

#: Answer for a plan that has no result.
LOST = "the filter's covariance lost positivity"
#: Column of the trace relative to its lower bound.
BESIDE = "trace / limit [-]"


def answers(plans: Plans) -> list[str]:
    """Return what each plan is worth, in one line.

    Time to converge, and the 1-sigma of the worst body axis of the attitude and of each bias. A
    robust time comes first: it is what to rely on. Where a plan's end is its own and not the
    filter's, the line has the 1-sigma of the attitude that most Monte Carlo runs keep.
    """
    model = plans.problem.model
    kept_sigma = plans.kept_sigma_deg if model.ends_by_design else np.full(len(plans.X), np.nan)
    times = plans.exactly.t_end, plans.robust_t_end, plans.kept_t_end, kept_sigma
    return [_answer(plans, *row) for row in zip(plans.sigma, *times, strict=True)]


def _answer(
    plans: Plans, sigma: Floats, t_end: float, robust: float, kept: float, kept_sigma: float
) -> str:
    if not math.isfinite(t_end):
        return LOST
    by_coils = plans.problem.scenario.turned_by_coils
    known = _known(plans.problem.model.suite, sigma, by_coils)
    late = None if math.isnan(kept) else within(kept)
    if math.isfinite(kept_sigma):
        late = f"{MOST_SAMPLES} keep attitude {two_digits(kept_sigma)} deg"
    converged, after = t_end < plans.problem.model.too_late, span(t_end)
    if math.isnan(robust):
        nominal = f"{after}; then {known}" if converged else f"not converged; after {after} {known}"
        return "; ".join(filter(None, [nominal, late]))
    own = f"robust time {span(robust)}" if robust < math.inf else "no robust time"
    nominal = f"{after}, then {known}" if converged else f"not converged, after {after} {known}"
    return "; ".join(filter(None, [own, late, nominal if by_coils else f"flown exactly {nominal}"]))


def _known(suite: Suite, sigma: Floats, of_flights: bool) -> str:
    """Return the 1-sigmas of the attitude and of each bias, in words."""
    if not np.isfinite(sigma).all():  # nothing follows from the mean over flights
        return f"{LOST} in Monte Carlo samples"
    parts, worsts = [], sigma.reshape(-1, 3).max(axis=1)
    for block, name, worst in zip(block_units(suite), suite.blocks, worsts, strict=True):
        if name == "attitude" or name.endswith(".bias"):
            parts.append(f"{block.label} {two_digits(worst * block.factor)} {block.unit}")
    flights = " of Monte Carlo samples" if of_flights else ""
    return f"{', '.join(parts)} (1-sigma{flights}, worst body axis)"


def exactly(scenario: Scenario) -> str:
    """What the title of a figure or table of the plan's own run ends with, if flights tell more."""
    return ", flown exactly" if scenario.flight or scenario.turned_by_coils else ""


def within(kept: float) -> str:
    """When most samples converge [s], in words."""
    if kept == math.inf:
        return f"fewer than {MOST_SAMPLES} converge"
    return f"{MOST_SAMPLES} converge within {span(kept)}"


def span(seconds: float) -> str:
    """A time as people say it, to the second: 1 h 40 min 5 s."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    parts = [(hours, "h"), (minutes, "min"), (rest, "s")]
    return " ".join(f"{value} {unit}" for value, unit in parts if value) or "0 s"


def two_digits(value: float) -> str:
    """A number above 0 with two significant digits, all of them if it has more before the point."""
    digits = 1 - math.floor(math.log10(float(f"{value:.1e}")))
    return f"{value:.{max(digits, 0)}f}"


def describe(plans: Plans) -> pd.DataFrame:
    """One row per plan.

    What `glance` has, and of each objective what 9 of 10 flights keep, see `Plans.promises`; if the
    scenario has flights of its own, what is promised over these and what is kept comes first.
    1-sigmas are those of `Plans.sigma`.
    """
    table, over_flights = glance(plans), plans.promises()
    if plans.problem.scenario.turned_by_coils:  # which what is flown exactly says little of
        table = table.assign(**worst_axes(plans.problem.model.suite, plans.sigma))
    if not plans.problem.scenario.flight:  # what is promised is what is flown
        return table.join(over_flights.filter(regex="^kept (?!/)"))
    return over_flights.filter(regex="^(promised|kept) (?!/)").join(table)


def glance(plans: Plans) -> pd.DataFrame:
    """One row per plan, of what one run of the filter tells.

    Columns: the objectives of the paper; ``t_end [orbits]``; ``trace / limit [-]``, how near the
    trace comes to what no maneuver can beat, if that is known; ``maneuver time [s]``, the sum of
    all durations; ``slew back until [s]``, if there is one, which may be after the scenario's
    duration; ``start UTC``, if it is free; one text per maneuver, its rates about body x / y / z
    [deg/s] and its duration [s]; and for each 3-vector of the error state the predicted 1-sigma at
    t_end of its worst body axis (the largest of the three, as comparable to a data sheet's value
    per axis). If the scenario has flights of its own, the paper's objectives are said to be of a
    plan that is flown exactly. A design whose covariance lost positivity has NaN in objectives and
    1-sigmas. A design that is no plan is a ValueError.
    """
    problem, designs, result = plans.problem, plans.X, plans.exactly
    variances = np.diagonal(result.covariance, axis1=1, axis2=2)
    sigma = np.sqrt(np.where(np.isnan(result.t_end)[:, None], np.nan, variances))
    t_end_name, trace_name = (OBJECTIVES[name].label for name in PAPER)
    durations = durations_of(designs)
    columns: dict[str, Any] = {
        t_end_name: result.t_end,
        "t_end [orbits]": result.t_end / problem.scenario.orbit.period,
        trace_name: result.trace,
    }
    with suppress(NoLimit):
        columns[BESIDE] = result.trace / problem.limit_curves.at(result.t_end)
    columns["maneuver time [s]"] = durations.sum(axis=1)
    if problem.scenario.maneuvers.slew_back:
        columns["slew back until [s]"] = plans.ends
    texts = [maneuver_texts(x) for x in designs]
    for m in range(durations.shape[1]):
        name = f"maneuver {m + 1}: x / y / z [deg/s] for d [s]"
        columns[name] = [text[m] for text in texts]
    table = pd.DataFrame(columns | worst_axes(problem.model.suite, sigma))
    if not problem.scenario.flight:
        return table
    exactly = {name: f"{name} flown exactly" for name in (t_end_name, trace_name, BESIDE)}
    return table.rename(columns=exactly)


def worst_axes(suite: Suite, sigma: Floats) -> dict[str, Any]:
    """Of 1-sigmas, shape (n, n_states), each 3-vector's largest, a column each."""
    blocks = block_units(suite)
    worst = sigma.reshape(len(sigma), len(blocks), 3).max(axis=2)
    return {
        f"{block.label} 1-sigma [{block.unit}]": values * block.factor
        for block, values in zip(blocks, worst.T, strict=True)
    }


def front_summary(scenario: Scenario, F: ArrayLike) -> dict[str, float]:
    """Distinct non-dominated points that converge within one orbital period, and later.

    F is (n, 2), t_end and trace. These are the counts of the paper's Table 3, whose runs last two
    orbits; in a longer run the second count holds every later orbit too.
    """
    table = np.asarray(F, dtype=float)
    t_end = table[nondominated(table), 0]
    first = int((t_end <= scenario.orbit.period).sum())
    return {"points, first orbit": first, "points, second orbit": len(t_end) - first}


def maneuver_texts(x: Floats) -> list[str]:
    """Each maneuver of a design as ``x / y / z for duration``, in deg/s and s; not its start."""
    maneuvers = x[: len(x) - len(x) % VARIABLES_PER_MANEUVER]
    return [
        f"{' / '.join(f'{rate:+.3f}' for rate in rates)} for {duration:.1f}"
        for *rates, duration in maneuvers.reshape(-1, VARIABLES_PER_MANEUVER)
    ]
