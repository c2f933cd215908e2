"""A problem of which each case spoils one part, as a plugin of somebody else may be."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from pymoo.core.problem import Problem

from mgeo import View

PART: dict[str, Any] = {}  # name of the part that is spoiled -> what is there instead


def _part(name: str, sound: Any) -> Any:
    part = PART.get(name, sound)
    if isinstance(part, Exception):
        raise part
    return part


class Faulty(Problem):
    """Schaffer's problem with all that a plugin may have."""

    def __init__(self) -> None:
        self._raise("construction")
        self.var_names, self.obj_names = ["x [m]", "y [m]"], ["a [s]", "b [s]"]
        super().__init__(n_var=2, n_obj=2, xl=-3.0, xu=3.0)

    @classmethod
    def from_options(cls, options: Any) -> Any:
        return _part("from_options", cls)() if "from_options" in PART else cls()

    def _raise(self, name: str) -> None:
        _part(name, None)

    def options(self) -> Any:
        return _part("options", {})

    def _evaluate(self, X: Any, out: Any, *args: Any, **kwargs: Any) -> None:
        x, y = X[:, 0], X[:, 1]
        F = np.column_stack([x**2 + y**2, (x - 2) ** 2 + y**2])
        part = _part("F", F)
        out["F"] = part(F) if callable(part) else part

    def indicator_space(self, F: Any) -> Any:
        part = _part("indicator_space", np.asarray(F) / 20.0)
        return part(F) if callable(part) else part

    def view(self, X: Any) -> Any:
        return _part("view", FaultyView(self, X))


class FaultyView(View):
    """All that is shown of it."""

    def describe(self) -> Any:
        return _part("describe", pd.DataFrame({"x": self.X[:, 0], "sum": self.X.sum(axis=1)}))

    def answers(self) -> Any:
        return _part("answers", [f"sum {total:.3g}" for total in self.X.sum(axis=1)])

    def limits(self) -> Any:
        row = {"unit": ["m"], "value": [1.0], "bound": ["at most"], "limit": [2.0], "margin": [1.0]}
        return _part("limits", [pd.DataFrame(row, index=["height"])] * len(self.X))

    def front_summary(self, F: Any) -> Any:
        return _part("front_summary", {"points": len(F)})

    def figures(self) -> Any:
        figure = go.Figure(
            go.Scatter(x=self.X[:, 0], y=self.X[:, 1], customdata=np.arange(len(self.X)))
        )
        return _part("figures", {"front": figure})

    def solution_figures(self) -> Any:
        return _part("solution_figures", [{"one": go.Figure(go.Scatter(y=x))} for x in self.X])
