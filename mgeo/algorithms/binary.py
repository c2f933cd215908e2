"""MGEO canonical and MGEO var, extremal optimization of bit strings."""

from abc import ABC
from collections.abc import Sequence
from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray, IntArray
from mgeo.algorithms.encoding import MAX_BITS, BitEncoding
from mgeo.algorithms.variables import KINDS, Variables
from mgeo.algorithms.walkers import IndependentWalkers
from mgeo.validation.arguments import validate_choice, validate_each, validate_integer

CODINGS = ("plain", "gray")


class BitStrings(IndependentWalkers, ABC):
    """Base class for algorithms that represent walkers as bit strings.

    A subclass defines in `build_layout` which bits compete with each other. The parameters are
    described in `MGEOCanonical`.
    """

    encoding: BitEncoding

    def __init__(
        self,
        tau: float | str = 3.0,
        n_walkers: int = 30,
        bits: int | Sequence[int] = 16,
        coding: str = "plain",
        **options: Any,
    ) -> None:
        super().__init__(tau=tau, n_walkers=n_walkers, **options)
        self.bits = validate_each("bits", bits, validate_integer, low=1, high=MAX_BITS)
        self.coding = validate_choice("coding", coding, CODINGS)

    def build_encoding(self, problem: Problem) -> BitEncoding:
        variables = Variables.from_problem(problem, KINDS)
        return BitEncoding.from_variables(variables, self.bits, self.coding == "gray")

    def propose(self) -> FloatArray:
        return 1.0 - self.walkers[:, self._coordinates]


class MGEOCanonical(BitStrings):
    """Multiobjective generalized extremal optimization with a binary encoding (M-GEO).

    In every generation, each walker generates one candidate per bit, with this bit flipped, and
    accepts one of its candidates. A generation takes as many evaluations as all walkers have bits.
    With a single objective, the algorithm is GEO.

    Parameters
    ----------
    tau : selection pressure, >= 0: the candidate of rank k is accepted with probability ~ k^-tau;
        or "a-geo1" or "a-geo2" for a tau that adapts during the run.
    n_walkers : number of independent walkers (n_i re-initializations in the papers).
    bits : bits of each real variable, 1 to 52: one number, or one per variable. Integers, binary
        variables and choices use the smallest sufficient number of bits.
    coding : "plain" for binary numbers, or "gray" for Gray codes, where neighboring numbers differ
        in one bit.
    options : `restart` and `patience` of `mgeo.algorithms.walkers.IndependentWalkers`, `sampling`
        and `archive_size` of `mgeo.algorithms.base.ExtremalOptimization`, and options of every
        pymoo algorithm: `termination` (5000 // n_walkers generations by default), `seed`, ...

    Raises
    ------
    TypeError, ValueError
        If a parameter is unknown, has the wrong type or is out of range.

    References
    ----------
    F. L. de Sousa, F. M. Ramos, P. Paglione, R. M. Girardi, "New stochastic algorithm for design
    optimization", AIAA Journal 41 (2003) 1808-1818 (GEO). R. L. Galski, doctoral thesis,
    INPE-14795-TDI/1238 (2006) (M-GEO), as implemented in MGEO.jl, which uses plain binary numbers.

    Examples
    --------
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import MGEOCanonical
    >>> result = minimize(ZDT1(n_var=4), MGEOCanonical(bits=10), ("n_eval", 3000), seed=1)
    >>> result.F.shape[1], bool(result.F.min() < 0.01)
    (2, True)
    """

    def build_layout(self) -> IntArray:
        return np.arange(self.encoding.length, dtype=np.intp)[None, :]


class MGEOVar(BitStrings):
    """Generalized extremal optimization that flips one bit of every variable at a time (M-GEO_var).

    In every generation, each walker generates one candidate per bit, with this bit flipped. The
    candidates of each variable are ranked separately, and one per variable is accepted, so that a
    walker changes all variables at once. The resulting point is evaluated in the next generation. A
    generation therefore takes as many evaluations as all walkers have bits, plus one per walker.
    (GEOvar_BINARIO.cs of leobeckerdaluz/GEO_OptimizationAlgorithms also evaluates the walkers, and
    A-GEO2 requires it; MGEO.jl does not.) With a single objective, the algorithm is GEO_var.

    Parameters
    ----------
    bits : bits of each real variable, 2 to 52: one number, or one per variable.
    tau : selection pressure among the bits of a variable, >= 0; otherwise as for `MGEOCanonical`.
    n_walkers, coding, options : as for `MGEOCanonical`.

    Raises
    ------
    TypeError, ValueError
        If a parameter is unknown, has the wrong type or is out of range. At the start of a run, if
        a variable has a single bit, which would flip in every generation.

    References
    ----------
    F. L. de Sousa, F. M. Ramos, P. Paglione, R. M. Girardi, "New stochastic algorithm for design
    optimization", AIAA Journal 41 (2003) 1808-1818 (GEO_var). I. Mainenti-Lopes, doctoral thesis,
    INPE-15384-TDI/1403 (2013), as implemented in MGEO.jl (M-GEO_var), which uses plain
    binary numbers.

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

    def build_layout(self) -> IntArray:
        if np.any(self.encoding.bits == 1):
            variable = int(np.argmax(self.encoding.bits == 1))
            raise ValueError(
                f"variable {variable} has 1 bit, which MGEOVar would flip in every generation: "
                "expected 2 or more. Use MGEOCanonical for binary variables"
            )
        return self.encoding.positions[self.encoding.bits > 0]
