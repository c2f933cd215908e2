"""Test problems with their optima moved off the bounds."""

from __future__ import annotations

from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray

#: By how much the box is wider on each side, as shares of its width. They differ, so that an
#: optimum in the middle of the box, as that of DTLZ1 and ZDT4, is not there either; and the points
#: mirrored by the new bounds are far from any optimum, too, such as 0.35 of WFG, 0 and 0.5.
BELOW, ABOVE = 0.7, 0.2


class Shifted(Problem):
    """A problem of real variables in a wider box, mirrored at its former bounds.

    Where variables are within the former bounds, objectives are what they were, so that all
    solutions of the problem are solutions still; but none of them lies on a bound any longer, and
    a step that ends there ends nowhere of interest. (CEC 2007 moved ZDT and DTLZ in the same way,
    by mirroring; Huang, Qin, Deb, Zitzler, Suganthan, Liang, Preuss & Huband 2007.)

    Parameters
    ----------
    inner : the problem; its bounds are finite.

    Raises
    ------
    ValueError : if its variables are not real, or not bounded.
    """

    def __init__(self, inner: Problem) -> None:
        real = inner.vtype in (None, float) and getattr(inner, "vars", None) is None
        if not real or inner.xl is None or inner.xu is None:
            raise ValueError(f"{inner.name()} cannot be shifted: expected bounded real variables")
        xl, xu = np.asarray(inner.xl, dtype=float), np.asarray(inner.xu, dtype=float)
        super().__init__(
            n_var=inner.n_var,
            n_obj=inner.n_obj,
            n_ieq_constr=inner.n_ieq_constr,
            n_eq_constr=inner.n_eq_constr,
            xl=xl - BELOW * (xu - xl),
            xu=xu + ABOVE * (xu - xl),
            vtype=float,
        )
        self.inner = inner

    def name(self) -> str:
        """As the problem's, and that it is shifted."""
        return f"Shifted {self.inner.name()}"

    def mirrored(self, x: FloatArray) -> FloatArray:
        """(n, n_var) variables within the former bounds, at which the problem is evaluated."""
        xl, xu = self.inner.xl, self.inner.xu
        return np.clip(np.where(x < xl, 2.0 * xl - x, np.where(x > xu, 2.0 * xu - x, x)), xl, xu)

    def _evaluate(self, X: FloatArray, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        values = ["F", "G", "H"]
        out.update(
            self.inner.evaluate(
                self.mirrored(X), return_values_of=values, return_as_dictionary=True
            )
        )

    def _calc_pareto_front(self, *args: Any, **kwargs: Any) -> Any:
        return self.inner.pareto_front(*args, **kwargs)
