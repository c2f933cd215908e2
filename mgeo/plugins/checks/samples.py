"""Small problems on which algorithms are checked."""

from typing import Any, Literal

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray

Constraint = Literal["none", "half", "impossible"]


class Bowls(Problem):
    """Squared distances to n_obj centers within [-2, 2]^n_var; they conflict.

    Parameters
    ----------
    n_var, n_obj : numbers of variables and objectives.
    constraint : "half" the points are feasible (x_1 >= 0), or none is ("impossible").
    """

    def __init__(self, n_var: int = 4, n_obj: int = 2, constraint: Constraint = "none") -> None:
        super().__init__(
            n_var=n_var, n_obj=n_obj, n_ieq_constr=int(constraint != "none"), xl=-2.0, xu=2.0
        )
        self.constraint = constraint
        self.seen: list[FloatArray] = []
        self.centers = np.zeros((n_obj, n_var))
        self.centers[np.arange(n_obj), np.arange(n_obj) % n_var] = np.linspace(-1.0, 1.0, n_obj)

    def _evaluate(self, X: FloatArray, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        self.seen.append(X.copy())
        out["F"] = np.sum((X[:, None, :] - self.centers) ** 2, axis=2)
        if self.constraint == "half":
            out["G"] = -X[:, :1]
        elif self.constraint == "impossible":
            out["G"] = 3.0 + X[:, :1]
