"""MGEO canonical and MGEO var: extremal optimization that flips bits."""

from abc import ABC
from collections.abc import Sequence
from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray, IntArray
from mgeo.algorithms.coding import MOST_BITS, BitCode
from mgeo.algorithms.variables import KINDS, Variables
from mgeo.algorithms.walkers import IndependentWalkers
from mgeo.validation.arguments import validate_choice, validate_each, validate_integer

CODINGS = ("plain", "gray")


class BitStrings(IndependentWalkers, ABC):
    """Independent walkers that are strings of bits; a subclass says how these are grouped.

    Parameters are those of `MGEOCanonical`.
    """

    code: BitCode

    def __init__(
        self,
        tau: float | str = 3.0,
        n_walkers: int = 30,
        bits: int | Sequence[int] = 16,
        coding: str = "plain",
        **options: Any,
    ) -> None:
        super().__init__(tau=tau, n_walkers=n_walkers, **options)
        self.bits = validate_each("bits", bits, validate_integer, low=1, high=MOST_BITS)
        self.coding = validate_choice("coding", coding, CODINGS)

    def representation(self, problem: Problem) -> BitCode:
        variables = Variables.of(problem, KINDS)
        return BitCode.of(variables, self.bits, self.coding == "gray")

    def propose(self) -> FloatArray:
        return 1.0 - self.walkers[:, self._coordinates]


class MGEOCanonical(BitStrings):
    """Multiobjective generalized extremal optimization on strings of bits (M-GEO).

    In every generation each bit of each walker gives one candidate, in which that bit alone is
    flipped; one of them is accepted. A generation therefore costs as many evaluations as all
    strings have bits. With one objective it is GEO.

    Parameters
    ----------
    tau : selection pressure, >= 0: the candidate of rank k is accepted with probability ~ k^-tau;
        or "a-geo1" or "a-geo2" to let it follow the search (`mgeo.algorithms.selection`).
    n_walkers : number of independent walkers, the n_i re-initializations of the papers.
    bits : of each real variable, 1 to 52: a number, or one per variable. Integers, binary
        variables and choices take as many as their levels need.
    coding : "plain" binary numbers, or "gray" codes, where neighbors differ in one bit.
    options : `restart` and `patience` of `mgeo.algorithms.walkers.IndependentWalkers`, `sampling`
        and `archive_size` of `mgeo.algorithms.base.ExtremalOptimization`, and those of every
        pymoo algorithm: `termination` (5000 // n_walkers generations unless given), `seed`, ...

    Raises
    ------
    TypeError, ValueError : for a parameter of the wrong type or out of range, or an unknown one.

    References
    ----------
    F. L. de Sousa, F. M. Ramos, P. Paglione, R. M. Girardi, "New stochastic algorithm for design
    optimization", AIAA Journal 41 (2003) 1808-1818 (GEO). R. L. Galski, doctoral thesis,
    INPE-14795-TDI/1238 (2006) (M-GEO), as implemented in MGEO.jl, whose codes are plain.

    Examples
    --------
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEOCanonical
    >>> result = minimize(ZDT1(n_var=4), MGEOCanonical(bits=10), ("n_eval", 3000), seed=1)
    >>> result.F.shape[1], bool(result.F.min() < 0.01)
    (2, True)
    """

    def layout(self) -> IntArray:
        return np.arange(self.code.length, dtype=np.intp)[None, :]


class MGEOVar(BitStrings):
    """Multiobjective generalized extremal optimization, one bit a variable (M-GEO_var).

    In every generation each bit of each walker gives one candidate, in which that bit alone is
    flipped. The bits of each variable are ranked among themselves and one of them is accepted,
    so that a walker changes in all variables at once. The point it reaches is evaluated with the
    next candidates: a generation costs as many evaluations as all strings have bits, and one per
    walker. (MGEO.jl leaves that one out; GEOvar_BINARIO.cs of leobeckerdaluz/
    GEO_OptimizationAlgorithms has it, and A-GEO2 needs it.) With one objective it is GEO_var.

    Parameters
    ----------
    bits : as for `MGEOCanonical`, at least 2.
    tau, n_walkers, coding, options : as for `MGEOCanonical`; tau ranks the bits of a variable.

    Raises
    ------
    TypeError, ValueError : for a parameter of the wrong type or out of range, or an unknown one.
        In a run, ValueError for a variable of one bit, which would flip in every generation.

    References
    ----------
    F. L. de Sousa, F. M. Ramos, P. Paglione, R. M. Girardi, "New stochastic algorithm for design
    optimization", AIAA Journal 41 (2003) 1808-1818 (GEO_var). I. Mainenti-Lopes, doctoral thesis,
    INPE-15384-TDI/1403 (2013), as implemented in MGEO.jl (M-GEO_var), whose codes are plain.

    Examples
    --------
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEOVar
    >>> result = minimize(ZDT1(n_var=4), MGEOVar(bits=10), ("n_eval", 3000), seed=1)
    >>> result.F.shape[1], bool(result.F.min() < 0.01)
    (2, True)
    """

    evaluates_walkers = True

    def layout(self) -> IntArray:
        if np.any(self.code.bits == 1):
            variable = int(np.argmax(self.code.bits == 1))
            raise ValueError(
                f"variable {variable} has 1 bit, which MGEOVar would flip in every generation: "
                "expected 2 or more (MGEOCanonical treats binary variables)"
            )
        return self.code.places[self.code.bits > 0]
