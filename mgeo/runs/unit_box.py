"""What algorithms of others that search the unit cube have in common as pymoo algorithms."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.algorithm import Algorithm
from pymoo.core.population import Population

from mgeo._typing import FloatArray


class UnitBox(Algorithm):
    """An algorithm of real variables that are scaled to their bounds, without constraints.

    Raises
    ------
    ValueError : when it is set up, if the problem has constraints, or no bounds.
    """

    title: str

    def _setup(self, problem: Any, **options: Any) -> None:
        if problem.has_constraints():
            raise ValueError(f"{self.title} does not treat constraints, which this problem has")
        if problem.xl is None or problem.xu is None:
            raise ValueError(f"{self.title} needs bounds, to scale variables to")

    def scaled(self, unit: ArrayLike) -> Population:
        """Candidates at (n, n_var) points of the cube; those outside at the nearest inside."""
        xl = np.asarray(self.problem.xl, dtype=float)
        xu = np.asarray(self.problem.xu, dtype=float)
        inside = np.clip(np.asarray(unit, dtype=float), 0.0, 1.0)
        return Population.new(X=np.clip(xl + (xu - xl) * inside, xl, xu))

    def drawn(self, n: int) -> FloatArray:
        """(n, n_var) uniform points of the cube, by the algorithm's own generator."""
        points: FloatArray = self.random_state.random((n, self.problem.n_var))
        return points
