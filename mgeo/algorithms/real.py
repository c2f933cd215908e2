"""MGEO_real: extremal optimization that perturbs one real variable at a time."""

import numpy as np

from mgeo._typing import FloatArray, IntArray
from mgeo.algorithms.real_steps import RealSteps


class MGEOReal(RealSteps):
    """Multiobjective generalized extremal optimization, real-coded (MGEO_real).

    In every generation each variable of each walker gives one candidate, in which that variable
    alone is perturbed by a normal step and clipped to its bounds; one of them is accepted. A
    generation therefore costs n_walkers x n_var evaluations. With one objective it is GEO_real1.

    Parameters
    ----------
    sigma : standard deviation of the step, > 0: a number, or one per variable.
    tau : greediness, >= 0: the candidate of rank k is accepted with probability ~ k^-tau; or
        "a-geo1" or "a-geo2" to let it follow the search (`mgeo.algorithms.adaptive`).
    n_walkers : number of independent walkers; `n_runs`, after the n_i re-initializations of the
        papers, is another name of it.
    perturbation : what sigma is a multiple of: "absolute" the variable's unit, "relative" its
        value (a variable at zero stays there), "range" the width of its bounds (for variables
        of different units).
    restart : "never", or where a walker begins anew that has not advanced for `patience`
        generations: at a "random" point, or at one of the "archive".
    patience : generations without progress before a restart.
    sampling : points at which the first walkers start: up to (n_walkers, n_var), population or
        pymoo `Sampling`; the others begin uniform within the bounds. Starting points are not
        evaluated themselves.
    archive_size : largest number of points in the front, None for all of them.
    options : options of every pymoo algorithm: `termination` (5000 // n_walkers generations unless
        given), `callback`, `output`, `verbose`, `seed`, `save_history`, ...

    Raises
    ------
    TypeError, ValueError : for a parameter of the wrong type or out of range, or an unknown one.

    References
    ----------
    I. Mainenti-Lopes, L. C. G. Souza, F. L. de Sousa, "Design of a nonlinear controller for a
    rigid-flexible satellite using multi-objective generalized extremal optimization with real
    codification", Shock and Vibration 19 (2012) 947-956. Public implementation: MGEO.jl.
    """

    def _layout(self) -> IntArray:
        return np.arange(self.problem.n_var, dtype=np.intp)[None, :]

    def _deviations(self, sigma: FloatArray) -> FloatArray:
        return sigma
