"""MGEO_real: extremal optimization that perturbs one real variable at a time."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.sampling import Sampling

from mgeo.algorithms.acceptance import IntArray
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.moves import SCALES, perturb
from mgeo.algorithms.parameters import choice, numbers
from mgeo.algorithms.starts import given_starts, uniform_starts
from mgeo.dominance import FloatArray


class MGEOReal(ExtremalOptimization):
    """Multiobjective generalized extremal optimization, real-coded (MGEO_real).

    In every generation each variable of each walker gives one candidate, in which that variable
    alone is perturbed by a normal step and clipped to its bounds; one of them is accepted. A
    generation therefore costs n_runs x n_var evaluations. With one objective it is GEO_real1.

    Parameters
    ----------
    sigma : standard deviation of the step, > 0: a number, or one per variable.
    tau : greediness, >= 0: the candidate of rank k is accepted with probability ~ k^-tau.
    n_runs : number of independent walkers (re-initializations).
    perturbation : what sigma is a multiple of: "absolute" the variable's unit, "relative" its
        value (a variable at zero stays there), "range" the width of its bounds (for variables
        of different units).
    sampling : starting points: (n_runs, n_var) array, population or pymoo `Sampling`; None for
        uniform within the bounds. They are not evaluated themselves.
    archive_size : largest number of points in the front, None for all of them.
    options : options of every pymoo algorithm: `termination` (5000 // n_runs generations unless
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

    def __init__(
        self,
        sigma: float | ArrayLike = 1.0,
        tau: float = 3.0,
        n_runs: int = 30,
        perturbation: str = "absolute",
        *,
        sampling: Sampling | ArrayLike | None = None,
        archive_size: int | None = None,
        **options: Any,
    ) -> None:
        super().__init__(tau=tau, n_runs=n_runs, archive_size=archive_size, options=options)
        self.sigma = numbers("sigma", sigma, above=0)
        self.perturbation = choice("perturbation", perturbation, SCALES)
        self.sampling = sampling

    def _start(self) -> FloatArray:
        if np.size(self.sigma) not in (1, self.problem.n_var):
            raise ValueError(
                f"sigma of length {np.size(self.sigma)}: expected one number, or one for each of "
                f"the {self.problem.n_var} variables"
            )
        if self.sampling is None:
            return uniform_starts(self.problem, self.streams)
        return given_starts(self.sampling, self.problem, self.n_runs, self.random_state)

    def _layout(self) -> IntArray:
        return np.arange(self.problem.n_var, dtype=np.intp)[None, :]

    def _propose(self) -> FloatArray:
        noise = np.stack([stream.standard_normal(self.problem.n_var) for stream in self.streams])
        scale = SCALES[self.perturbation]
        values = perturb(self.walkers, noise, self.sigma, scale, *self.problem.bounds())
        return values[:, None, :]

    def _decode(self, points: FloatArray) -> FloatArray:
        return points
