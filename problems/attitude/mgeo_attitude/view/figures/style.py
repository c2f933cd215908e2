"""Solutions selected for figures, and the style of lines, titles and layouts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mgeo.evaluation.dominance import find_front_rows
from mgeo.figures.style import COLORS
from mgeo_attitude._typing import Floats
from mgeo_attitude.criteria.objectives import attitude_sigma_deg
from mgeo_attitude.view.plans import Plans

#: Dash patterns. Their gaps are short, so that a steep dashed line does not look interrupted.
_DASHES = ("solid", "9px,3px", "3px,3px", "12px,3px,3px,3px", "18px,3px", "6px,3px,3px,3px")


def build_line_style(index: int, width: float = 2) -> dict[str, Any]:
    """Return the color, dash pattern and width of a curve as a plotly dict."""
    color, dash = COLORS[index % len(COLORS)], _DASHES[index % len(_DASHES)]
    return {"color": color, "dash": dash, "width": width}


def compute_panels_height(rows: int) -> int:
    return 220 + 230 * rows


def build_title(text: str) -> dict[str, Any]:
    return {
        "text": text,
        "x": 0.02,
        "xanchor": "left",
        "y": 1.0,
        "yref": "container",
        "yanchor": "top",
        "pad": {"t": 9},
        "font": {"size": 15},
    }


def build_small_layout(text: str) -> dict[str, Any]:
    margin = {"l": 65, "r": 10, "t": 55, "b": 45}
    return {"title": build_title(text), "height": 300, "margin": margin}


#: Largest number of solutions of which all are shown in detail.
MAX_SELECTED = 6


@dataclass(frozen=True)
class PlottedSolutions:
    """Plans shown in a figure, with their objectives, attitude 1-sigma and labels.

    Attributes
    ----------
    numbers : array of int, shape (n,)
        Rows of the plans in the front.
    X, F : arrays, shapes (n, n_var) and (n, 2)
        Designs, and their nominal t_end [s] and trace.
    sigma_deg : array, shape (n,)
        Attitude 1-sigma at t_end [deg]; see `attitude_sigma_deg`.
    labels : tuple of str
        ``plan 3``, or ``plan 3, min-time`` with the role of the plan.
    """

    numbers: NDArray[np.int64]
    X: Floats
    F: Floats
    sigma_deg: Floats
    labels: tuple[str, ...]

    @classmethod
    def from_plans(cls, plans: Plans) -> PlottedSolutions:
        """Select the plans that have finite objectives.

        Plans whose covariance lost positivity are left out.

        Raises
        ------
        ValueError
            If no plan has finite objectives.
        """
        designs, result = plans.X, plans.nominal
        F = np.column_stack([result.t_end, result.trace])
        rows = np.flatnonzero(np.isfinite(F).all(axis=1))
        if not rows.size:
            raise ValueError(
                f"X of shape {designs.shape}: expected at least one design with finite objectives"
            )
        sigma = attitude_sigma_deg(result.covariance[rows])
        labels = tuple(f"plan {row}" for row in rows)
        return cls(rows, designs[rows], F[rows], sigma, labels)

    def find_roles(self, knee_index: int | None = None) -> dict[int, str]:
        """Return a dict that maps plan indices to the roles "knee", "min-time" and "min-trace".

        Parameters
        ----------
        knee_index : int, optional
            Index of the knee; None if there is no knee.
        """
        front = find_front_rows(self.F)
        min_time, min_trace = int(front[0]), int(front[-1])
        roles = {} if knee_index is None else {knee_index: "knee"}
        roles[min_time] = "min-time"  # It replaces "knee" at an end of the front.
        roles[min_trace] = "min-trace" if min_trace != min_time else "min-time, min-trace"
        return roles

    def format_label(self, index: int, roles: Mapping[int, str]) -> str:
        """Return the label of a plan including its role, such as "plan 3, min-time"."""
        return ", ".join([self.labels[index], *([roles[index]] if index in roles else [])])

    def select_representative(self, knee_index: int | None = None) -> PlottedSolutions:
        """Select the plans that have a role, or all plans if there are at most six.

        Parameters
        ----------
        knee_index : int, optional
            Index of the knee; None if there is no knee.

        Returns
        -------
        PlottedSolutions
            In the order of t_end, with roles in their labels.
        """
        roles = self.find_roles(knee_index)
        rows = range(len(self.F)) if len(self.F) <= MAX_SELECTED else roles
        order = sorted(rows, key=lambda row: tuple(self.F[row]))
        labels = tuple(self.format_label(row, roles) for row in order)
        return PlottedSolutions(
            self.numbers[order], self.X[order], self.F[order], self.sigma_deg[order], labels
        )
