"""Which maneuver bought what: trace and 1-sigma of every state at the end of each phase."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mgeo_attitude.filter.history import FilterHistory
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.motion import phases
from mgeo_attitude.view.observability.states import States


def contributions(model: FilterModel, design: ArrayLike, history: FilterHistory) -> pd.DataFrame:
    """One row for the start and one for the end of each phase of a plan.

    Parameters
    ----------
    design : array_like, shape (4 m,)
    history : FilterHistory
        The filter's run of that design (`filter_history`).

    Returns
    -------
    DataFrame
        Index: ``start``, ``maneuver 1``, ..., ``rate held``. Columns: ``time [s]``; ``trace [-]``
        then; ``contribution [%]``, the phase's part of the whole fall of the trace's logarithm
        (phases multiply: the first halving counts as much as the last); and the 1-sigma of every
        state in the unit its name carries.
    """
    flown = phases(design, history.t_end, model.step, model.slew_limits)
    times = np.array([0.0, *(phase.end for phase in flown)])
    steps = np.rint(times / model.step).astype(np.int64)
    trace = history.trace[steps]
    fall = np.append(0.0, -np.diff(np.log(trace)))
    columns = {"time [s]": times, "trace [-]": trace, "contribution [%]": 100.0 * fall / fall.sum()}
    states = States.of(model.suite)
    sigma = (history.sigma[steps] * states.factors).T
    for name, unit, values in zip(states.names, states.units, sigma, strict=True):
        columns[f"{name} [{unit}]"] = values
    return pd.DataFrame(columns, index=["start", *(phase.label for phase in flown)])
