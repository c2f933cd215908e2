"""Test problems with wider bounds, so that no optimum lies on a bound."""

from __future__ import annotations

from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray

#: Extension of the box below and above, relative to its width. The values differ so that an optimum
#: in the middle of the box, as in DTLZ1 and ZDT4, does not remain in the middle. With these values,
#: the new bounds also map to points far from the usual optima at 0, 0.35 (WFG) and 0.5.
EXTENSION_BELOW, EXTENSION_ABOVE = 0.7, 0.2


class ShiftedProblem(Problem):
    """Test problem with bounds moved outward, so that no optimum lies on a bound.

    Beyond the original bounds, the problem is extended by mirroring. Within the original bounds,
    the objectives and constraints are unchanged, so that all optima remain optima. No optimum lies
    on a bound of the wider box, which removes the advantage of algorithms that clip steps to the
    bounds. The CEC 2007 competition extended ZDT and DTLZ by mirroring in the same way (Huang, Qin,
    Deb, Zitzler, Suganthan, Liang, Preuss & Huband 2007).

    Parameters
    ----------
    inner : Problem
        Original problem, with finite bounds.

    Raises
    ------
    ValueError
        If a variable of the original problem is not real or not bounded.
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
            xl=xl - EXTENSION_BELOW * (xu - xl),
            xu=xu + EXTENSION_ABOVE * (xu - xl),
            vtype=float,
        )
        self.inner = inner

    def name(self) -> str:
        return f"Shifted {self.inner.name()}"

    def mirror(self, x: FloatArray) -> FloatArray:
        """Mirror points outside the original bounds back into these bounds.

        Parameters
        ----------
        x : array, shape (n, n_var)
            Points inside the wider bounds.

        Returns
        -------
        array, shape (n, n_var)
        """
        xl, xu = self.inner.xl, self.inner.xu
        return np.clip(np.where(x < xl, 2.0 * xl - x, np.where(x > xu, 2.0 * xu - x, x)), xl, xu)

    def _evaluate(self, X: FloatArray, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        values = ["F", "G", "H"]
        out.update(
            self.inner.evaluate(self.mirror(X), return_values_of=values, return_as_dictionary=True)
        )

    def _calc_pareto_front(self, *args: Any, **kwargs: Any) -> Any:
        return self.inner.pareto_front(*args, **kwargs)
