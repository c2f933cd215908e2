"""Error budget of a plan, measurement times of its sensors, and uncertainty reduction by phase."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mgeo_attitude.filter import error_budget
from mgeo_attitude.filter.history import FilterHistory, can_measure
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.motion import Motion, Phase, list_phases
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.view.observability.covariance import StateLabels

#: Number of error sources of each 1-sigma in the table of `find_error_drivers`.
_N_DRIVERS = 3
#: Name of the last row of an error budget, the root sum square of all contributions.
TOTAL = "all"


def compute_error_budget(
    model: FilterModel, design: ArrayLike, history: FilterHistory
) -> pd.DataFrame:
    """Compute the contribution of each error source to the final 1-sigmas.

    Parameters
    ----------
    model : FilterModel
    design : array_like, shape (4 m,)
    history : FilterHistory
        Covariance history of the design until its convergence.

    Returns
    -------
    DataFrame
        1-sigmas: one row per error source and a last row ``all``; one column per 3-vector of the
        state, in the unit that the column name contains. The squares of the contributions add up
        to the square of ``all``; see `filter.error_budget`.
    """
    parts_by_source = error_budget.compute_error_budget(model, design, history.t_end)
    columns = {}
    for block, unit in enumerate(list_block_units(model.suite)):
        axis = _find_worst_axis(history, block)
        parts = np.append(
            parts_by_source.variances[:, axis], parts_by_source.variances[:, axis].sum()
        )
        columns[f"{unit.label} [{unit.unit}]"] = np.sqrt(parts) * unit.factor
    return pd.DataFrame(columns, index=pd.Index([*parts_by_source.sources, TOTAL], name="source"))


def find_error_drivers(
    model: FilterModel, budget_table: pd.DataFrame, improvements: pd.DataFrame
) -> pd.DataFrame:
    """Return the largest error sources of each required 1-sigma, by default of the attitude.

    Parameters
    ----------
    model : FilterModel
    budget_table : DataFrame
        Table of `compute_error_budget`.
    improvements : DataFrame
        Table of `improvements.evaluate_improvements`.

    Returns
    -------
    DataFrame
        Three rows per 3-vector of the state, the largest source first. Columns: ``quantity``;
        ``unit``; ``error source``; ``share [%]`` of the variance; ``predicted`` 1-sigma;
        and ``if halved``, the 1-sigma which the plan would reach with half of the error source, or
        NaN for a source that `improvements` does not contain.
    """
    units, tables = list_block_units(model.suite), []
    required = [b for b in range(len(units)) if np.isfinite(model.required_sigma[3 * b])]
    for block in required or [0]:
        unit, column = units[block], budget_table.iloc[:, block]
        largest = column.drop(TOTAL).nlargest(_N_DRIVERS)
        columns = {
            "quantity": unit.label,
            "unit": unit.unit,
            "error source": largest.index,
            "share [%]": 100.0 * (largest / column[TOTAL]).to_numpy() ** 2,
            "predicted": column[TOTAL],
            "if halved": improvements.iloc[:, block].reindex(largest.index).to_numpy(),
        }
        tables.append(pd.DataFrame(columns))
    return pd.concat(tables, ignore_index=True)


def compute_measurement_times(
    model: FilterModel, phases: Sequence[Phase], design: ArrayLike, history: FilterHistory
) -> pd.DataFrame:
    """Compute the measurement time of each sensor in each phase of a plan.

    Parameters
    ----------
    model : FilterModel
    phases : sequence of Phase
        Phases until the end of the `history`.
    design : array_like, shape (4 m,)
    history : FilterHistory
        Covariance history of the design.

    Returns
    -------
    DataFrame
        One row per phase: its ``duration [s]``, and a column ``NAME [s]`` for each sensor, the
        number of its measurements times its sample interval.
    """
    omega = Motion.from_design(model, design, len(history.times) - 1).rates
    edges = [(round(p.start / model.step), round(p.end / model.step)) for p in phases]
    columns: dict[str, object] = {"duration [s]": [phase.duration for phase in phases]}
    for index, sensor in enumerate(model.suite.sensors):
        is_measuring = can_measure(model, index, history.attitude, omega)
        interval = sensor.sample_interval or model.step
        columns[f"{sensor.name} [s]"] = [
            interval * int(is_measuring[first + 1 : last + 1].sum()) for first, last in edges
        ]
    return pd.DataFrame(columns, index=[phase.label for phase in phases])


def _find_worst_axis(history: FilterHistory, block: int) -> int:
    return 3 * block + int(history.sigma[-1, 3 * block : 3 * block + 3].argmax())


def compute_uncertainty_by_phase(
    model: FilterModel, design: ArrayLike, history: FilterHistory
) -> pd.DataFrame:
    """Return the trace and the 1-sigma of every state at the end of each phase.

    Parameters
    ----------
    model : FilterModel
    design : array_like, shape (4 m,)
    history : FilterHistory
        Covariance history of the design until its convergence; see `run_filter`.

    Returns
    -------
    DataFrame
        Index: ``start``, ``maneuver 1``, ..., ``constant-rate hold``. Columns: ``time [s]``;
        ``trace [-]``; ``contribution [%]``, the share of the phase in the total decrease of the
        logarithm of the trace; and the 1-sigma of every state in the unit that the column name
        contains.
    """
    phases = list_phases(design, history.t_end, model.step, model.slew_limits)
    times = np.array([0.0, *(phase.end for phase in phases)])
    steps = np.rint(times / model.step).astype(np.int64)
    trace = history.trace[steps]
    decrease = np.append(0.0, -np.diff(np.log(trace)))
    columns = {
        "time [s]": times,
        "trace [-]": trace,
        "contribution [%]": 100.0 * decrease / decrease.sum(),
    }
    states = StateLabels.from_suite(model.suite)
    sigma = (history.sigma[steps] * states.factors).T
    for name, unit, values in zip(states.names, states.units, sigma, strict=True):
        columns[f"{name} [{unit}]"] = values
    return pd.DataFrame(columns, index=["start", *(phase.label for phase in phases)])
