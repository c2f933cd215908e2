"""MGEO_real and MGEO_real2, extremal optimization with normal steps of real variables."""

import math
from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray, IntArray
from mgeo.algorithms.encoding import RealEncoding
from mgeo.algorithms.steps import BOUNDS, NORMAL, SCALES, StepLaw, perturb
from mgeo.algorithms.variables import Variables
from mgeo.algorithms.walkers import IndependentWalkers
from mgeo.validation.arguments import (
    validate_choice,
    validate_each,
    validate_integer,
    validate_number,
)

SCHEDULES = ("factorial", "geometric")


class RealVectors(IndependentWalkers, ABC):
    """Base class for algorithms that represent walkers as vectors of real variables.

    A subclass implements `compute_step_sigmas`, and can replace the normal law of the steps by
    setting the class attribute ``law``. The parameters are described in `MGEOReal`.
    """

    #: Probability law of the steps.
    law: ClassVar[StepLaw] = NORMAL

    def __init__(
        self,
        sigma: float | ArrayLike = 1.0,
        tau: float | str = 3.0,
        n_walkers: int = 30,
        perturbation: str = "absolute",
        bounds: str = "clip",
        **options: Any,
    ) -> None:
        super().__init__(tau=tau, n_walkers=n_walkers, **options)
        checked = validate_each("sigma", sigma, validate_number, above=0)
        self.sigma = np.array(checked) if isinstance(checked, list) else checked
        self.perturbation = validate_choice("perturbation", perturbation, SCALES)
        self.bounds = validate_choice("bounds", bounds, BOUNDS)

    @abstractmethod
    def compute_step_sigmas(self, sigma: FloatArray) -> FloatArray:
        """Return the standard deviation of the random step of each candidate.

        Parameters
        ----------
        sigma : array, shape (n_var,)
            Parameter `sigma` for each variable.

        Returns
        -------
        array that broadcasts to (n_walkers, n_groups, group_size)
            Standard deviations; the last two axes are those of `build_layout`. `MGEOReal` has one
            group with a candidate per variable, so that the shape is (n_var,) for equal values of
            all walkers and (n_walkers, 1, n_var) otherwise. `MGEOReal2` has a group of `n_steps`
            candidates per variable: (n_var, n_steps) or (n_walkers, n_var, n_steps).
        """

    def build_encoding(self, problem: Problem) -> RealEncoding:
        if np.size(self.sigma) not in (1, problem.n_var):
            raise ValueError(
                f"sigma of length {np.size(self.sigma)}: expected one number, or one for each of "
                f"the {problem.n_var} variables"
            )
        return RealEncoding(Variables.from_problem(problem, ["real"]))

    def propose(self) -> FloatArray:
        steps = self._coordinates
        noise = np.array([self.law.draw(stream, steps.shape) for stream in self.streams])
        xl, xu = self.variables.xl, self.variables.xu
        sigma = self.compute_step_sigmas(np.broadcast_to(self.sigma, xl.shape))
        try:
            sigma = np.broadcast_to(sigma, noise.shape)
        except ValueError as error:
            raise ValueError(
                f"{type(self).__name__}.compute_step_sigmas returned an array of shape "
                f"{np.shape(sigma)}: expected a shape that broadcasts to {noise.shape}, the number "
                "of walkers, of groups, and of candidates per group"
            ) from error
        return perturb(
            self.walkers[:, steps],
            noise,
            sigma,
            SCALES[self.perturbation],
            xl[steps],
            xu[steps],
            BOUNDS[self.bounds],
            lambda: np.array([stream.random(steps.shape) for stream in self.streams]),
            self.law,
        )


class MGEOReal(RealVectors):
    """Multiobjective generalized extremal optimization for real variables (MGEO_real).

    In every generation, each walker generates one candidate per variable, in which a normal step
    perturbs this variable within its bounds, and accepts one of its candidates. A generation takes
    n_walkers x n_var evaluations. With a single objective, the algorithm is GEO_real1.

    Parameters
    ----------
    sigma : standard deviation of the step, > 0: a number, or one per variable.
    tau : selection pressure, >= 0: the candidate of rank k is accepted with probability ~ k^-tau;
        or "a-geo1" or "a-geo2" for a tau that adapts during the run.
    n_walkers : number of independent walkers (n_i re-initializations in the papers).
    perturbation : meaning of sigma: "absolute", in the unit of the variable; "relative", a fraction
        of its value (a variable at zero stays there); "range", a fraction of the width of its
        bounds (for variables of different units).
    bounds : treatment of steps beyond the bounds: "clip" to the bound, as published, "reflect" at
        the bound, or "resample" until the step stays inside.
    options : `restart` and `patience` of `mgeo.algorithms.walkers.IndependentWalkers`, `sampling`
        and `archive_size` of `mgeo.algorithms.base.ExtremalOptimization`, and options of every
        pymoo algorithm: `termination` (5000 // n_walkers generations by default), `seed`, ...

    Raises
    ------
    TypeError, ValueError
        If a parameter is unknown, has the wrong type or is out of range.

    References
    ----------
    I. Mainenti-Lopes, L. C. G. Souza, F. L. de Sousa, "Design of a nonlinear controller for a
    rigid-flexible satellite using multi-objective generalized extremal optimization with real
    codification", Shock and Vibration 19 (2012) 947-956. Public implementation: MGEO.jl.

    Examples
    --------
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEOReal
    >>> result = minimize(ZDT1(n_var=4), MGEOReal(sigma=0.1), ("n_eval", 3000), seed=1)
    >>> result.F.shape[1], bool(result.F.min() < 0.01)
    (2, True)
    """

    def build_layout(self) -> IntArray:
        return np.arange(self.problem.n_var, dtype=np.intp)[None, :]

    def compute_step_sigmas(self, sigma: FloatArray) -> FloatArray:
        return sigma


class MGEOReal2(RealVectors):
    """Multiobjective extremal optimization with several step sizes per real variable (MGEO_real2).

    In every generation, each walker generates `n_steps` candidates per variable, in which a normal
    step perturbs this variable within its bounds. The standard deviation decreases from step to
    step. The candidates of each variable are ranked separately and one per variable is accepted, so
    that a walker changes all variables at once. The resulting point is evaluated in the next
    generation. A generation takes n_walkers x (n_var x n_steps + 1) evaluations. With a single
    objective, the algorithm is GEO_real2.

    Parameters
    ----------
    sigma : standard deviation of the largest step, > 0: a number, or one per variable.
    n_steps : number of steps per variable (P), at least 2.
    divisor : divisor of the standard deviation between steps (s), > 0.
    schedule : "factorial" for sigma_{j+1} = sigma_j / (s j), or "geometric" for sigma_j / s.
    tau : selection pressure among the steps of each variable, >= 0; otherwise as for `MGEOReal`.
    n_walkers, perturbation, bounds, options : as for `MGEOReal`.

    Raises
    ------
    TypeError, ValueError
        If a parameter is unknown, has the wrong type or is out of range.

    References
    ----------
    GEO_real2 was developed by I. Mainenti-Lopes (INPE). This class follows GEO_REAL2.cs of
    leobeckerdaluz/GEO_OptimizationAlgorithms (master's thesis at INPE), which calls "factorial"
    with s = 2 the original schedule; the thesis itself was not available. The extension to several
    objectives, analogous to MGEO_real, is an interpretation.

    Examples
    --------
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEOReal2
    >>> result = minimize(ZDT1(n_var=4), MGEOReal2(0.5, n_steps=4), ("n_eval", 3000), seed=1)
    >>> result.F.shape[1], bool(result.F.min() < 0.01)
    (2, True)
    """

    evaluates_walkers = True

    def __init__(
        self,
        sigma: float | ArrayLike = 1.0,
        tau: float | str = 3.0,
        n_walkers: int = 30,
        perturbation: str = "absolute",
        n_steps: int = 5,
        divisor: float = 2.0,
        schedule: str = "factorial",
        **options: Any,
    ) -> None:
        super().__init__(sigma, tau, n_walkers, perturbation, **options)
        self.n_steps = validate_integer("n_steps", n_steps, low=2)
        self.divisor = validate_number("divisor", divisor, above=0)
        self.schedule = validate_choice("schedule", schedule, SCHEDULES)

    def build_layout(self) -> IntArray:
        return np.repeat(np.arange(self.problem.n_var, dtype=np.intp)[:, None], self.n_steps, 1)

    def compute_step_sigmas(self, sigma: FloatArray) -> FloatArray:
        factors = self.divisor ** -np.arange(float(self.n_steps))
        if self.schedule == "factorial":
            factors /= [math.factorial(j) for j in range(self.n_steps)]
        return np.asarray(sigma[:, None] * factors)
