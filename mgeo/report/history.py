"""Hypervolume of a recorded run against evaluations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from numpy.typing import NDArray
from pymoo.core.problem import Problem

from mgeo.evaluation.dominance import nondominated
from mgeo.figures.style import COLORS
from mgeo.plugins import protocol
from mgeo.plugins.view import TOLERANCE
from mgeo.runs.hypervolume import MAX_OBJECTIVES, scaled, unit_hypervolume
from mgeo.store.recorder import read_record
from mgeo.store.run import Outcome
from mgeo.store.run_folder import RECORD_FOLDER

_SAMPLES = 60


def recorded_history(folder: Path, problem: Problem, outcome: Outcome) -> go.Figure | None:
    """Return a figure of the hypervolume; None if the run has no record or no hypervolume.

    Raises
    ------
    ValueError
        If the record is damaged, or of another run.
    """
    try:
        record = read_record(folder / RECORD_FOLDER)
    except FileNotFoundError:
        return None
    found = hypervolume_history(problem, outcome, record)
    if found is None:
        return None
    figure = go.Figure().add_scatter(
        x=found[0],
        y=found[1],
        mode="lines",
        line={"shape": "hv", "color": COLORS[0], "width": 2.5},
        hovertemplate="%{x:,d} evaluations: %{y:.4f}<extra></extra>",
    )
    title = f"evaluations, after {outcome.rough:,} by estimates" if outcome.rough else "evaluations"
    figure.update_xaxes(title=title, type="log", dtick=1)
    figure.update_yaxes(title="hypervolume", rangemode="tozero")
    return figure.update_layout(margin={"l": 70, "r": 20, "t": 20, "b": 55}, height=340)


def hypervolume_history(
    problem: Problem, outcome: Outcome, record: pd.DataFrame
) -> tuple[NDArray[np.int64], NDArray[np.float64]] | None:
    """Return numbers of evaluations, and the hypervolume of all solutions found by then.

    The hypervolume is measured in the indicator space of the problem, or else with the objectives
    scaled to the range of all feasible evaluations. Low-fidelity evaluations come first and do not
    count.

    Parameters
    ----------
    record
        Table from `mgeo.read_record`, with the objectives and constraints.

    Returns
    -------
    evaluations, hypervolume : arrays, shape (k,)
        None for one objective, for more than `MAX_OBJECTIVES`, or without a feasible evaluation.
    """
    if not 1 < problem.n_obj <= MAX_OBJECTIVES:
        return None
    G, H = (record[_constraints(problem, kind)].to_numpy(float) for kind in "gh")
    feasible = (G <= 0.0).all(axis=1) & (np.abs(H) <= TOLERANCE).all(axis=1)
    F = record[list(outcome.objectives)].to_numpy(float).copy()
    F[record["failed"].to_numpy(bool) | ~feasible] = np.nan
    precise = F[outcome.rough :]
    reached = precise[~np.isnan(precise).any(axis=1)]
    if not len(reached):
        return None
    space = protocol.indicator_space(problem)
    ideal, nadir = reached.min(axis=0), reached.max(axis=0)
    ends = np.unique(np.geomspace(outcome.rough + 1, len(F), _SAMPLES).astype(np.int64))
    front, volumes, done = F[:0], [], outcome.rough
    for end in ends:
        candidates = np.vstack([front, F[done:end]])
        front, done = candidates[nondominated(candidates)], end
        points = scaled(front, ideal, nadir) if space is None else space(front)
        volumes.append(unit_hypervolume(points) if len(front) else 0.0)
    return ends, np.array(volumes)


def _constraints(problem: Problem, kind: str) -> list[str]:
    n = {"g": problem.n_ieq_constr, "h": problem.n_eq_constr}[kind]
    return [f"{kind}{j + 1}" for j in range(n)]
