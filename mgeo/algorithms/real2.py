"""MGEO_real2: extremal optimization that tries several step sizes in every real variable."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.sampling import Sampling

from mgeo._typing import FloatArray, IntArray
from mgeo._validation import validate_choice, validate_integer, validate_number
from mgeo.algorithms.constructors import takes_n_runs
from mgeo.algorithms.real_steps import RealSteps

SCHEDULES = ("factorial", "geometric")


def shares(n_steps: int, divisor: float, schedule: str) -> FloatArray:
    """(n_steps,) sigma_j / sigma_1: each is the one before over s j ("factorial") or s."""
    powers: FloatArray = divisor ** -np.arange(float(n_steps))
    if schedule == "factorial":
        powers /= [math.factorial(j) for j in range(n_steps)]
    return powers


class MGEOReal2(RealSteps):
    """Multiobjective generalized extremal optimization with several steps a variable (real2).

    In every generation each variable of each walker gives `n_steps` candidates, in which that
    variable alone is perturbed by normal steps of ever smaller deviation and clipped to its
    bounds. The steps of each variable are ranked among themselves and one of them is accepted, so
    that a walker moves in all variables at once. The point it reaches is evaluated with the next
    candidates: a generation costs n_walkers x (n_var x n_steps + 1) evaluations. With one objective
    it is GEO_real2.

    Parameters
    ----------
    sigma : standard deviation of the widest step, > 0: a number, or one per variable.
    tau : greediness, >= 0: the step of rank k is accepted with probability ~ k^-tau; or "a-geo1"
        or "a-geo2" to let it follow the search (`mgeo.algorithms.adaptive`).
    n_walkers : number of independent walkers; `n_runs`, after the n_i re-initializations of the
        papers, is another name of it.
    perturbation : what sigma is a multiple of: "absolute" the variable's unit, "relative" its
        value (a variable at zero stays there), "range" the width of its bounds (for variables
        of different units).
    n_steps : steps tried in each variable (P), at least 2.
    divisor : by what the deviations shrink (s), > 0.
    schedule : "factorial", sigma_{j+1} = sigma_j / (s j), or "geometric", sigma_j / s.
    restart : "never", or where a walker begins anew that has not advanced for `patience`
        generations: at a "random" point, or at one of the "archive".
    patience : generations without progress before a restart.
    sampling : points at which the first walkers start: up to (n_walkers, n_var), population or
        pymoo `Sampling`; the others begin uniform within the bounds.
    archive_size : largest number of points in the front, None for all of them.
    options : options of every pymoo algorithm: `termination` (5000 // n_walkers generations unless
        given), `callback`, `output`, `verbose`, `seed`, `save_history`, ...

    Raises
    ------
    TypeError, ValueError : for a parameter of the wrong type or out of range, or an unknown one.

    References
    ----------
    GEO_real2 is of I. Mainenti-Lopes (INPE). We follow GEO_REAL2.cs of
    leobeckerdaluz/GEO_OptimizationAlgorithms (master's thesis at INPE), where "factorial" with
    s = 2 is called the original schedule; the thesis itself was not at hand. The step to several
    objectives, in the way of MGEO_real, is our reading.
    """

    _evaluates_walkers = True

    @takes_n_runs
    def __init__(
        self,
        sigma: float | ArrayLike = 1.0,
        tau: float | str = 3.0,
        n_walkers: int = 30,
        perturbation: str = "absolute",
        n_steps: int = 5,
        divisor: float = 2.0,
        schedule: str = "factorial",
        *,
        restart: str = "never",
        patience: int = 50,
        sampling: Sampling | ArrayLike | None = None,
        archive_size: int | None = None,
        **options: Any,
    ) -> None:
        super().__init__(
            sigma=sigma,
            tau=tau,
            n_walkers=n_walkers,
            perturbation=perturbation,
            restart=restart,
            patience=patience,
            sampling=sampling,
            archive_size=archive_size,
            **options,
        )
        self.n_steps = validate_integer("n_steps", n_steps, low=2)
        self.divisor = validate_number("divisor", divisor, above=0)
        self.schedule = validate_choice("schedule", schedule, SCHEDULES)

    def _layout(self) -> IntArray:
        return np.repeat(np.arange(self.problem.n_var, dtype=np.intp)[:, None], self.n_steps, 1)

    def _deviations(self, sigma: FloatArray) -> FloatArray:
        return sigma[:, None] * shares(self.n_steps, self.divisor, self.schedule)
