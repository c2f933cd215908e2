"""Figures of the page on the MGEO family. All points come from runs of the algorithms."""

import numpy as np
import plotly.graph_objects as go
from draw import format_for_page
from pymoo.core.algorithm import Algorithm
from pymoo.core.problem import Problem
from pymoo.optimize import minimize

from mgeo import MGEODirected, MGEOStaged
from mgeo.algorithms.selection import build_weight_vectors

BLUE, ORANGE, GREEN, GRAY = "#0072b2", "#d55e00", "#009e73", "#767676"
START = (0.15, 0.9)


class TwoSpheres(Problem):
    """Squared distances from two points; the front consists of the points between them."""

    def __init__(self):
        super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.stack([((X - c) ** 2).sum(axis=1) for c in (0.3, 0.7)], axis=1)


class Valley(Problem):
    """Two ellipsoids with axes of different length, parallel to the variables or rotated."""

    def __init__(self, is_rotated):
        super().__init__(n_var=10, n_obj=2, xl=-1.0, xu=1.0)
        random = np.random.default_rng(1).standard_normal((10, 10))
        rotation = np.linalg.qr(random)[0] if is_rotated else np.eye(10)
        self.scaled_axes = rotation * np.geomspace(1.0, 30.0, 10)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.stack([(((X - c) @ self.scaled_axes) ** 2).sum(1) for c in (-0.3, 0.4)], 1)


def draw_selection() -> go.Figure:
    """Draw the probability of acceptance over the rank of ten candidates."""
    k = np.arange(1, 11)
    figure = go.Figure()
    for tau, color, dash in ((0.0, GRAY, "dot"), (1.0, ORANGE, "dash"), (3.0, BLUE, "solid")):
        weights = k**-tau
        figure.add_scatter(
            x=k,
            y=weights / weights.sum(),
            mode="lines+markers",
            name=f"τ = {tau:g}",
            line={"color": color, "dash": dash},
        )
    figure.update_xaxes(title="rank k of the candidate", dtick=1)
    figure.update_yaxes(title="probability", tickformat=".0%", rangemode="tozero")
    return format_for_page(figure, 340)


def draw_walk(algorithm: Algorithm, n_generations: int = 12) -> go.Figure:
    """Draw the candidates of the first generation of one walker, and the path of the walker.

    The algorithm has one walker, which starts at START.
    """
    problem = TwoSpheres()
    algorithm.setup(problem, seed=3, termination=("n_gen", n_generations))
    path, first = [np.array([START])], None
    while algorithm.has_next():
        algorithm.next()
        first = algorithm.pop.get("X") if first is None else first
        path.append(algorithm.encoding.decode(algorithm.walkers).copy())
    path = np.vstack(path)
    figure = go.Figure()
    figure.add_scatter(x=[0.3, 0.7], y=[0.3, 0.7], name="front", line={"color": GREEN, "width": 4})
    _add_points(figure, first, "candidates of the first generation", BLUE, "circle", 7)
    figure.add_scatter(
        x=path[:, 0],
        y=path[:, 1],
        mode="lines+markers",
        name=f"path of the walker, {n_generations} generations",
        line={"color": ORANGE, "width": 1.5},
        marker={"size": 5},
    )
    _add_points(figure, path[:1], "start", ORANGE, "x", 12)
    return _set_plane(figure)


def draw_kind(candidates: np.ndarray, points: dict[str, np.ndarray]) -> go.Figure:
    """Draw candidates of one kind, and the points from which they are generated."""
    figure = go.Figure()
    looks = {
        "archive": ("black", "circle-open", 8),
        "nearest archived point": ("black", "circle", 9),
        "walker": (ORANGE, "x", 12),
        "best point of the walker": (ORANGE, "diamond", 10),
    }
    _add_points(figure, candidates, "candidates", BLUE, "circle", 4)
    for name, where in points.items():
        _add_points(figure, np.atleast_2d(where), name, *looks[name])
    return _set_plane(figure)


def draw_decomposition() -> go.Figure:
    """Draw the front of a run, the directions of the walkers, and the points nearest to them."""
    result = minimize(TwoSpheres(), MGEODirected(), ("n_eval", 600), seed=1)
    F = (result.F - result.F.min(axis=0)) / np.ptp(result.F, axis=0)
    figure = go.Figure()
    for i, weights in enumerate(np.unique(build_weight_vectors(16, 2, 0.4), axis=0)):
        # A point on this ray has equal weighted objectives.
        ray = np.maximum(weights[::-1], 0.0) / weights.max()
        figure.add_scatter(
            x=[0.0, ray[0]],
            y=[0.0, ray[1]],
            mode="lines",
            name="direction of a walker",
            line={"color": GRAY, "width": 1, "dash": "dot"},
            showlegend=i == 0,
        )
        nearest = F[(F * weights).max(axis=1).argmin()][None]
        _add_points(figure, nearest, "nearest archived point", ORANGE, "circle", 9)
        figure.data[-1].showlegend = i == 0
    _add_points(figure, F, "archive", BLUE, "circle-open", 5)
    figure.update_xaxes(title="first objective, scaled", range=[-0.03, 1.05])
    figure.update_yaxes(title="second objective, scaled", range=[-0.03, 1.05])
    return format_for_page(figure, 420)


def draw_recombination_share() -> go.Figure:
    """Draw the share of recombination during a run with independent and with coupled variables."""
    figure = go.Figure()
    for is_rotated, name, color in ((False, "independent", BLUE), (True, "coupled", ORANGE)):
        shares = []
        minimize(
            Valley(is_rotated),
            MGEODirected(),
            ("n_eval", 4_800),
            seed=1,
            callback=lambda run, shares=shares: shares.append(
                run.state.credit.compute_share(*run.recombination)
            ),
        )
        evaluations = 48 * np.arange(1, len(shares) + 1)
        figure.add_scatter(x=evaluations, y=shares, name=f"{name} variables", line={"color": color})
    figure.update_xaxes(title="evaluations", tickformat=",d")
    figure.update_yaxes(title="share of recombination", tickformat=".0%", rangemode="tozero")
    return format_for_page(figure, 360)


def draw_fidelity() -> go.Figure:
    """Draw the fidelity level over a run with the default schedule of `MGEOStaged`."""
    steps = [0.0, *MGEOStaged().fidelity_schedule]
    figure = go.Figure()
    figure.add_scatter(
        x=[*steps, 1.0],
        y=[*range(len(steps)), len(steps) - 1],
        mode="lines+markers",
        line={"shape": "hv", "color": BLUE},
    )
    figure.update_xaxes(title="share of the run", tickformat=".0%")
    figure.update_yaxes(title="fidelity level", dtick=1)
    return format_for_page(figure, 300).update_layout(showlegend=False)


def _add_points(figure, points, name, color, symbol, size):
    figure.add_scatter(
        x=points[:, 0],
        y=points[:, 1],
        mode="markers",
        name=name,
        marker={"color": color, "symbol": symbol, "size": size},
    )


def _set_plane(figure: go.Figure) -> go.Figure:
    figure.update_xaxes(title="first variable", range=[-0.03, 1.03])
    figure.update_yaxes(title="second variable", range=[-0.03, 1.03])
    return format_for_page(figure, 420)
