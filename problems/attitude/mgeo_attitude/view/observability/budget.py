"""Why a plan leaves what it leaves: the error budget, what sensors saw and maneuvers bought."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mgeo_attitude.filter.error_budget import error_budget
from mgeo_attitude.filter.history import FilterHistory, can_measure
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.motion import Motion, Phase, phases
from mgeo_attitude.sensors.suite import block_units
from mgeo_attitude.view.observability.alternatives import most
from mgeo_attitude.view.observability.covariance import States

#: Largest parts that `reasons` names.
_NAMED = 3


def budget(model: FilterModel, design: ArrayLike, history: FilterHistory) -> pd.DataFrame:
    """What of the 1-sigma of the worst body axis at the end is from which source.

    One row a source, one column for each 3-vector of the state, in the unit its name carries, and a
    last row ``all``. Squares add up to that of ``all``, 1-sigmas do not; see
    `filter.error_budget`.
    """
    found = error_budget(model, design, history.t_end)
    columns = {}
    for block, unit in enumerate(block_units(model.suite)):
        axis = _worst(history, block)
        parts = np.append(found.variances[:, axis], found.variances[:, axis].sum())
        columns[f"{unit.label} [{unit.unit}]"] = np.sqrt(parts) * unit.factor
    return pd.DataFrame(columns, index=pd.Index([*found.sources, "all"], name="source"))


def reasons(
    model: FilterModel, table: pd.DataFrame, changes: pd.DataFrame, history: FilterHistory
) -> list[str]:
    """Return the drivers of each required 1-sigma, or else of the attitude's, a line for each.

    The largest parts, how little was learned of the first if it was there at the start, and the
    changes that would help most.

    Parameters
    ----------
    table : DataFrame
        The `budget`.
    changes : DataFrame
        The `remedies`.
    """
    units, lines = block_units(model.suite), []
    left = (history.sigma[-1] / model.initial_sigma).reshape(-1, 3).max(axis=1)
    initial = {f"initial {unit.label}": share for unit, share in zip(units, left, strict=True)}
    required = [b for b in range(len(units)) if np.isfinite(model.required_sigma[3 * b])]
    for block in required or [0]:
        unit, column = units[block], table.iloc[:, block]
        parts = column.drop("all").nlargest(_NAMED)
        named = ", ".join(f"{sigma:.3g} {source}" for source, sigma in parts.items())
        axis = "xyz"[_worst(history, block) % 3]
        line = f"{unit.label} {axis} {column['all']:.3g} {unit.unit}: {named}"
        share = initial.get(str(parts.index[0]))
        if share is not None:
            line += f"; {share:.0%} of its initial 1-sigma is left"
        better = most(changes.iloc[:, block])
        helps = [f"{value:.3g} {unit.unit} with {name}" for name, value in better.items()]
        lines.append(line + (f"; it would be {', '.join(helps)}" if helps else ""))
    return lines


def sensor_use(
    model: FilterModel, phases: Sequence[Phase], design: ArrayLike, history: FilterHistory
) -> pd.DataFrame:
    """For how long each sensor could measure in each phase of a design [s].

    Parameters
    ----------
    phases
        Those until the end of the `history`, which is the filter's run of the design.

    Returns
    -------
    DataFrame
        One row a phase, with its ``duration [s]``, and a column ``NAME [s]`` for each sensor: the
        number of its samples times the time between them.
    """
    omega = Motion.of(model, design, len(history.times) - 1).rates
    edges = [(round(p.start / model.step), round(p.end / model.step)) for p in phases]
    columns: dict[str, object] = {"duration [s]": [phase.duration for phase in phases]}
    for index, sensor in enumerate(model.suite.sensors):
        seen = can_measure(model, index, history.attitude, omega)
        every = sensor.sample_interval or model.step
        columns[f"{sensor.name} [s]"] = [
            every * int(seen[first + 1 : last + 1].sum()) for first, last in edges
        ]
    return pd.DataFrame(columns, index=[phase.label for phase in phases])


def _worst(history: FilterHistory, block: int) -> int:
    return 3 * block + int(history.sigma[-1, 3 * block : 3 * block + 3].argmax())


def contributions(model: FilterModel, design: ArrayLike, history: FilterHistory) -> pd.DataFrame:
    """One row for the start and one for the end of each phase of a plan.

    Parameters
    ----------
    history : FilterHistory
        The filter's run of the design, shape (4 m,); see `filter_history`.

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
