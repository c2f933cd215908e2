"""Where flights end, and what they keep, that are turned by what their gyro says."""

from __future__ import annotations

import numpy as np
import pandas as pd
from mgeo_attitude.plan import ManeuverPlan

from mgeo_calibration.flight import draw
from mgeo_calibration.flight.as_flown import END, beside, by_gyro, values

#: Share of the flights that a table's column is of, beside half of them.
MOST = 0.9
HALF, MOST_OF, BROKEN = "half of flights", "9 of 10", "broken [%]"


def ends(plan: ManeuverPlan, n_runs: int, seed: int) -> pd.DataFrame:
    """Of flights with the errors of `verify`, until the plan's end; a row as in `as_flown`.

    Columns: ``unit``; ``plan``; what half and nine of ten flights come to or stay on the better
    side of; ``bound``, ``limit``; and in how many it is ``broken [%]``. None of a satellite that
    coils turn, whatever its gyro says.
    """
    if plan.scenario.turned_by_coils:
        return pd.DataFrame()
    model = plan.problem.model
    n = min(round(min(plan.duration, plan.scenario.duration) / model.step), model.n_steps)
    flown = [
        values(plan, by_gyro(plan, model, draw(model, n, generator), n))
        for generator in np.random.default_rng(seed).spawn(n_runs)
    ]
    planned = values(plan, plan.attitude[: n + 1])
    each = [beside(plan, planned, one) for one in flown]
    found = each[0][["unit", "plan", "bound", "limit"]].copy()
    table = np.array([one["flown"] for one in each])
    least = (found["bound"] == "at least").to_numpy()
    for at, name in ((0.5, HALF), (MOST, MOST_OF)):
        low, high = np.quantile(table, [1.0 - at, at], axis=0)
        found[name] = np.where(least, low, high)
    found[BROKEN] = 100.0 * np.mean([~one["kept"].to_numpy(bool) for one in each], axis=0)
    found.loc[found["bound"] == "", BROKEN] = np.nan
    return found[["unit", "plan", HALF, MOST_OF, "bound", "limit", BROKEN]]


def told(found: pd.DataFrame) -> list[str]:
    """In a line where flights end, and which limits they break; none without flights."""
    if not len(found):
        return []
    half, most = found.loc[END, [HALF, MOST_OF]]
    broken = found[found[BROKEN] > 0.0]
    limits = "".join(
        f"; {label} broken in {share:.3g} %" for label, share in broken[BROKEN].items()
    )
    return [
        "turned by what the gyro says, from an attitude that is not quite the plan's, half of the "
        f"flights end less than {half:.3g} deg off it, 9 of 10 less than {most:.3g} deg{limits}"
    ]
