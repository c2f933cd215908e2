"""Hypervolume of a recorded run as a function of the number of evaluations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from numpy.typing import NDArray
from pymoo.core.problem import Problem

from mgeo.evaluation.dominance import find_nondominated
from mgeo.figures.style import COLORS
from mgeo.plugins import protocol
from mgeo.plugins.view import EQUALITY_TOLERANCE
from mgeo.runs.hypervolume import MAX_OBJECTIVES, compute_unit_hypervolume, scale_objectives
from mgeo.store.recorder import read_record
from mgeo.store.run import Outcome
from mgeo.store.run_folder import RECORD_FOLDER

_N_POINTS = 60  # number of points of the curve


def draw_hypervolume_history(folder: Path, problem: Problem, outcome: Outcome) -> go.Figure | None:
    """Plot the hypervolume of a recorded run over the number of evaluations.

    Returns None if the run folder has no record of the evaluations, or no hypervolume is defined
    (see `compute_hypervolume_history`).

    Parameters
    ----------
    folder
        Run folder.
    problem
        Problem of the run.
    outcome
        Outcome of the run.

    Raises
    ------
    ValueError
        If the record is damaged or belongs to another run.
    """
    try:
        record = read_record(folder / RECORD_FOLDER)
    except FileNotFoundError:
        return None
    history = compute_hypervolume_history(problem, outcome, record)
    if history is None:
        return None
    figure = go.Figure().add_scatter(
        x=history[0],
        y=history[1],
        mode="lines",
        line={"shape": "hv", "color": COLORS[0], "width": 2.5},
        hovertemplate="%{x:,d} evaluations: %{y:.4f}<extra></extra>",
    )
    title = (
        f"evaluations, of which the first {outcome.n_low_fidelity:,} have low fidelity"
        if outcome.n_low_fidelity
        else "evaluations"
    )
    figure.update_xaxes(title=title, type="log", dtick=1)
    figure.update_yaxes(title="hypervolume", rangemode="tozero")
    return figure.update_layout(margin={"l": 70, "r": 20, "t": 20, "b": 55}, height=340)


def compute_hypervolume_history(
    problem: Problem, outcome: Outcome, record: pd.DataFrame
) -> tuple[NDArray[np.int64], NDArray[np.float64]] | None:
    """Compute the hypervolume of the front as a function of the number of evaluations.

    The front after each number of evaluations consists of all feasible designs so far that no other
    feasible design dominates.

    The objectives are mapped by ``map_to_indicator_space`` of the problem or, if the problem does
    not define it, scaled to their range over all feasible evaluations. The initial low-fidelity
    evaluations are excluded.

    Parameters
    ----------
    problem
        Problem of the run.
    outcome
        Outcome of the run.
    record
        Table of all evaluations, as returned by `mgeo.read_record`.

    Returns
    -------
    evaluations, hypervolume : arrays, shape (k,)
        None if the problem has one objective or more than `MAX_OBJECTIVES`, or if no evaluation is
        feasible.
    """
    if not 1 < problem.n_obj <= MAX_OBJECTIVES:
        return None
    G, H = (record[_list_constraint_columns(problem, kind)].to_numpy(float) for kind in "gh")
    is_feasible = (G <= 0.0).all(axis=1) & (np.abs(H) <= EQUALITY_TOLERANCE).all(axis=1)
    F = record[list(outcome.objectives)].to_numpy(float).copy()
    F[record["failed"].to_numpy(bool) | ~is_feasible] = np.nan
    full_fidelity_F = F[outcome.n_low_fidelity :]
    feasible_F = full_fidelity_F[~np.isnan(full_fidelity_F).any(axis=1)]
    if not len(feasible_F):
        return None
    indicator_map = protocol.get_indicator_map(problem)
    ideal, nadir = feasible_F.min(axis=0), feasible_F.max(axis=0)
    ends = np.unique(np.geomspace(outcome.n_low_fidelity + 1, len(F), _N_POINTS).astype(np.int64))
    front, volumes, start = F[:0], [], outcome.n_low_fidelity
    for end in ends:
        candidates = np.vstack([front, F[start:end]])
        front, start = candidates[find_nondominated(candidates)], end
        points = (
            scale_objectives(front, ideal, nadir) if indicator_map is None else indicator_map(front)
        )
        volumes.append(compute_unit_hypervolume(points) if len(front) else 0.0)
    return ends, np.array(volumes)


def _list_constraint_columns(problem: Problem, kind: str) -> list[str]:
    n = {"g": problem.n_ieq_constr, "h": problem.n_eq_constr}[kind]
    return [f"{kind}{j + 1}" for j in range(n)]
