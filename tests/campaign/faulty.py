"""A problem of which each case spoils one part, as a plugin of somebody else may be."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from pymoo.core.problem import Problem

PART: dict[str, Any] = {}  # name of the part that is spoiled -> what is there instead


class Faulty(Problem):
    """Schaffer's problem with all that a plugin may have."""

    def __init__(self) -> None:
        self._raise("construction")
        self.var_names = self._part("var_names", ["x [m]", "y [m]"])
        self.obj_names = self._part("obj_names", ["a [s]", "b [s]"])
        super().__init__(
            n_var=self._part("n_var", 2),
            n_obj=self._part("n_obj", 2),
            n_ieq_constr=self._part("n_ieq_constr", 0),
            xl=self._part("xl", np.array([-3.0, -3.0])),
            xu=self._part("xu", np.array([3.0, 3.0])),
        )

    @classmethod
    def from_options(cls, options: Any) -> Any:
        return cls._part("from_options", cls)() if "from_options" in PART else cls()

    @staticmethod
    def _part(name: str, sound: Any) -> Any:
        part = PART.get(name, sound)
        if isinstance(part, Exception):
            raise part
        return part

    def _raise(self, name: str) -> None:
        self._part(name, None)

    def options(self) -> Any:
        return self._part("options", {})

    def _evaluate(self, X: Any, out: Any, *args: Any, **kwargs: Any) -> None:
        x, y = X[:, 0], X[:, 1]
        F = np.column_stack([x**2 + y**2, (x - 2) ** 2 + y**2])
        part = self._part("F", F)
        out["F"] = part(F) if callable(part) else part
        if "G" in PART:
            out["G"] = self._part("G", None)

    def indicator_space(self, F: Any) -> Any:
        part = self._part("indicator_space", np.asarray(F) / 20.0)
        return part(F) if callable(part) else part

    def describe(self, X: Any) -> Any:
        return self._part("describe", pd.DataFrame({"x": X[:, 0], "sum": X.sum(axis=1)}))

    def answers(self, X: Any) -> Any:
        return self._part("answers", [f"sum {total:.3g}" for total in X.sum(axis=1)])

    def limits(self, X: Any) -> Any:
        row = {"unit": ["m"], "value": [1.0], "bound": ["at most"], "limit": [2.0], "margin": [1.0]}
        return self._part("limits", [pd.DataFrame(row, index=["height"])] * len(X))

    def front_summary(self, F: Any) -> Any:
        return self._part("front_summary", {"points": len(F)})

    def figures(self, X: Any) -> Any:
        figure = go.Figure(go.Scatter(x=X[:, 0], y=X[:, 1], customdata=np.arange(len(X))))
        return self._part("figures", {"front": figure})

    def solution_figures(self, X: Any) -> Any:
        return self._part("solution_figures", [{"one": go.Figure(go.Scatter(y=x))} for x in X])
