"""A problem whose front is known in closed form."""

import numpy as np
from pymoo.core.problem import Problem


class Ellipsoids(Problem):
    """Two rotated ellipsoids of condition 100 with their minima apart, within wide bounds."""

    def __init__(self, n_var=4):
        super().__init__(n_var=n_var, n_obj=2, xl=-5.0, xu=5.0)
        turned, _ = np.linalg.qr(np.random.default_rng(3).standard_normal((n_var, n_var)))
        self.metric = turned * 10.0 ** np.linspace(0, 2, n_var) @ turned.T
        self.ends = np.zeros(n_var), np.ones(n_var)

    def _evaluate(self, X, out, *args, **kwargs):
        steps = [X - end for end in self.ends]
        out["F"] = np.column_stack([np.einsum("ni,ij,nj->n", s, self.metric, s) for s in steps])
