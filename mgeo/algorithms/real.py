"""MGEO_real and MGEO_real2: extremal optimization that perturbs real variables by normal steps."""

import math
from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray, IntArray
from mgeo.algorithms.coding import RealCode
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


class RealSteps(IndependentWalkers, ABC):
    """Independent walkers that are points of the search space.

    A subclass supplies the scales of the steps; another law of the steps is another value of the
    class attribute ``law``. Parameters are those of `MGEOReal`.
    """

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
    def deviations(self, sigma: FloatArray) -> FloatArray:
        """Standard deviation of each step of `layout`, from one per variable."""

    def representation(self, problem: Problem) -> RealCode:
        if np.size(self.sigma) not in (1, problem.n_var):
            raise ValueError(
                f"sigma of length {np.size(self.sigma)}: expected one number, or one for each of "
                f"the {problem.n_var} variables"
            )
        return RealCode(Variables.of(problem, ["real"]))

    def propose(self) -> FloatArray:
        steps = self._coordinates
        noise = np.array([self.law.draw(stream, steps.shape) for stream in self.streams])
        xl, xu = self.variables.xl, self.variables.xu
        sigma = self.deviations(np.broadcast_to(self.sigma, xl.shape))
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


class MGEOReal(RealSteps):
    """Multiobjective generalized extremal optimization, real-coded (MGEO_real).

    In every generation each variable of each walker gives one candidate, in which that variable
    alone is perturbed by a normal step within its bounds; one of them is accepted. A
    generation therefore costs n_walkers x n_var evaluations. With one objective it is GEO_real1.

    Parameters
    ----------
    sigma : standard deviation of the step, > 0: a number, or one per variable.
    tau : selection pressure, >= 0: the candidate of rank k is accepted with probability ~ k^-tau;
        or "a-geo1" or "a-geo2" to let it follow the search (`mgeo.algorithms.selection`).
    n_walkers : number of independent walkers, the n_i re-initializations of the papers.
    perturbation : what sigma is a multiple of: "absolute" the variable's unit, "relative" its
        value (a variable at zero stays there), "range" the width of its bounds (for variables
        of different units).
    bounds : what becomes of a step that leaves them: "clip" to the bound, as published, "reflect"
        from it, or "resample", drawn anew until it stays inside (`mgeo.algorithms.steps`).
    options : `restart` and `patience` of `mgeo.algorithms.walkers.IndependentWalkers`, `sampling`
        and `archive_size` of `mgeo.algorithms.base.ExtremalOptimization`, and those of every
        pymoo algorithm: `termination` (5000 // n_walkers generations unless given), `seed`, ...

    Raises
    ------
    TypeError, ValueError : for a parameter of the wrong type or out of range, or an unknown one.

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

    def layout(self) -> IntArray:
        return np.arange(self.problem.n_var, dtype=np.intp)[None, :]

    def deviations(self, sigma: FloatArray) -> FloatArray:
        return sigma


class MGEOReal2(RealSteps):
    """Multiobjective generalized extremal optimization with several steps a variable (real2).

    In every generation each variable of each walker gives `n_steps` candidates, in which that
    variable alone is perturbed by normal steps of ever smaller deviation, within its bounds. The
    steps of each variable are ranked among themselves and one of them is accepted, so that a
    walker moves in all variables at once. The point it reaches is evaluated with the next
    candidates: a generation costs n_walkers x (n_var x n_steps + 1) evaluations. With one
    objective it is GEO_real2.

    Parameters
    ----------
    sigma : standard deviation of the widest step, > 0: a number, or one per variable.
    n_steps : steps tried in each variable (P), at least 2.
    divisor : by what the deviations shrink (s), > 0.
    schedule : "factorial", sigma_{j+1} = sigma_j / (s j), or "geometric", sigma_j / s.
    tau, n_walkers, perturbation, bounds, options : as for `MGEOReal`; tau ranks the steps of a
        variable.

    Raises
    ------
    TypeError, ValueError : for a parameter of the wrong type or out of range, or an unknown one.

    References
    ----------
    GEO_real2 is of I. Mainenti-Lopes (INPE). We follow GEO_REAL2.cs of
    leobeckerdaluz/GEO_OptimizationAlgorithms (master's thesis at INPE), where "factorial" with
    s = 2 is called the original schedule; the thesis itself was not at hand. The step to several
    objectives, in the way of MGEO_real, is our reading.

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

    def layout(self) -> IntArray:
        return np.repeat(np.arange(self.problem.n_var, dtype=np.intp)[:, None], self.n_steps, 1)

    def deviations(self, sigma: FloatArray) -> FloatArray:
        shares = self.divisor ** -np.arange(float(self.n_steps))
        if self.schedule == "factorial":
            shares /= [math.factorial(j) for j in range(self.n_steps)]
        return np.asarray(sigma[:, None] * shares)
