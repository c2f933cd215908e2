"""Solutions of the attitude problem in an engineer's terms."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mgeo.algorithms.dominance import nondominated
from mgeo_attitude._typing import Floats
from mgeo_attitude.bound import NoLimit
from mgeo_attitude.criteria.objectives import OBJECTIVES
from mgeo_attitude.environment.time_stamps import utc_texts
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.scenario import Scenario
from mgeo_attitude.scenario.settings import PAPER
from mgeo_attitude.sensors.suite import block_units
from mgeo_attitude.view.plans import Plans

if TYPE_CHECKING:
    import pandas as pd


#: How near a plan's trace comes to what no maneuver can beat.
BESIDE = "trace / limit [-]"


def describe(plans: Plans) -> pd.DataFrame:
    """One row per plan.

    What `glance` has, and of each objective what 9 of 10 flights keep, see `Plans.promises`; if the
    scenario has flights of its own, what is promised over these and what is kept comes first.
    """
    table, over_flights = glance(plans), plans.promises()
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
    import pandas as pd

    problem, designs, result = plans.problem, plans.X, plans.exactly
    variances = np.diagonal(result.covariance, axis1=1, axis2=2)
    sigma = np.sqrt(np.where(np.isnan(result.t_end)[:, None], np.nan, variances))
    t_end_name, trace_name = (OBJECTIVES[name].label for name in PAPER)
    maneuvers = designs[:, : VARIABLES_PER_MANEUVER * problem.scenario.maneuvers.count]
    durations = maneuvers[:, VARIABLES_PER_MANEUVER - 1 :: VARIABLES_PER_MANEUVER]
    columns: dict[str, object] = {
        t_end_name: result.t_end,
        "t_end [orbits]": result.t_end / problem.scenario.orbit.period,
        trace_name: result.trace,
    }
    with suppress(NoLimit):
        columns[BESIDE] = result.trace / problem.limit_curves.at(result.t_end)
    columns["maneuver time [s]"] = durations.sum(axis=1)
    if problem.scenario.maneuvers.slew_back:
        columns["slew back until [s]"] = plans.ends
    if problem.start_times is not None:
        begins = problem.start_times.times[problem.start_times.split(designs)[1]]
        columns["start UTC"] = utc_texts(problem.scenario.epoch, begins)
    texts = [maneuver_texts(x) for x in maneuvers]
    for m in range(durations.shape[1]):
        name = f"maneuver {m + 1}: x / y / z [deg/s] for d [s]"
        columns[name] = [text[m] for text in texts]
    blocks = block_units(problem.model.suite)
    worst = sigma.reshape(len(designs), len(blocks), 3).max(axis=2)
    for block, values in zip(blocks, worst.T, strict=True):
        columns[f"{block.label} 1-sigma [{block.unit}]"] = values * block.factor
    table = pd.DataFrame(columns)
    if not problem.scenario.flight:
        return table
    exactly = {name: f"{name} flown exactly" for name in (t_end_name, trace_name, BESIDE)}
    return table.rename(columns=exactly)


def front_summary(scenario: Scenario, F: ArrayLike) -> dict[str, float]:
    """Distinct non-dominated points that converge within one orbital period, and later.

    F is (n, 2), t_end and trace. These are the counts of the paper's Table 3, whose runs last two
    orbits; in a longer run the second count holds every later orbit too.
    """
    table = np.asarray(F, dtype=float)
    if table.ndim != 2 or table.shape[1] != 2:
        raise ValueError(f"F of shape {table.shape}: expected (n, 2), t_end [s] and trace")
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
