"""What the real-coded members share: a candidate takes a normal step in one variable."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.problem import Problem
from pymoo.core.sampling import Sampling

from mgeo._typing import FloatArray
from mgeo._validation import validate_choice, validate_each, validate_number
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.constructors import takes_n_runs
from mgeo.algorithms.moves import SCALES, perturb
from mgeo.algorithms.variables import Variables


class RealSteps(ExtremalOptimization, ABC):
    """Extremal optimization whose walkers are points; a leaf says which steps they try.

    Parameters
    ----------
    sigma : standard deviation of a step, > 0: a number, or one per variable.
    perturbation : what sigma is a multiple of, one of `mgeo.algorithms.moves.SCALES`.
    tau, n_walkers, restart, patience, sampling, archive_size, options : as for
        `ExtremalOptimization`.
    """

    @takes_n_runs
    def __init__(
        self,
        sigma: float | ArrayLike = 1.0,
        tau: float | str = 3.0,
        n_walkers: int = 30,
        perturbation: str = "absolute",
        *,
        restart: str = "never",
        patience: int = 50,
        sampling: Sampling | ArrayLike | None = None,
        archive_size: int | None = None,
        **options: Any,
    ) -> None:
        super().__init__(
            tau=tau,
            n_walkers=n_walkers,
            restart=restart,
            patience=patience,
            sampling=sampling,
            archive_size=archive_size,
            options=options,
        )
        checked = validate_each("sigma", sigma, validate_number, above=0)
        self.sigma = np.array(checked) if isinstance(checked, list) else checked
        self.perturbation = validate_choice("perturbation", perturbation, SCALES)

    @abstractmethod
    def _deviations(self, sigma: FloatArray) -> FloatArray:
        """Standard deviation of each step of `_layout`, from one per variable."""

    def _variables(self, problem: Problem) -> Variables:
        if np.size(self.sigma) not in (1, problem.n_var):
            raise ValueError(
                f"sigma of length {np.size(self.sigma)}: expected one number, or one for each of "
                f"the {problem.n_var} variables"
            )
        return Variables.of(problem, ["real"])

    def _draw(self, streams: Sequence[np.random.Generator]) -> FloatArray:
        xl, xu = self.variables.xl, self.variables.xu
        unit = np.array([stream.random(len(xl)) for stream in streams])
        starts: FloatArray = np.clip(xl + (xu - xl) * unit, xl, xu)
        return starts

    def _propose(self) -> FloatArray:
        steps = self._coordinates
        noise = np.array([stream.standard_normal(steps.shape) for stream in self.streams])
        xl, xu = self.variables.xl, self.variables.xu
        sigma = self._deviations(np.broadcast_to(self.sigma, xl.shape))
        scale = SCALES[self.perturbation]
        return perturb(self.walkers[:, steps], noise, sigma, scale, xl[steps], xu[steps])

    def _decode(self, points: FloatArray) -> FloatArray:
        return points

    def _encode(self, values: FloatArray) -> FloatArray:
        return values
