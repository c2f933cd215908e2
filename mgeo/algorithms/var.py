"""MGEO var: extremal optimization that flips one bit of every variable at a time."""

import numpy as np

from mgeo._typing import IntArray
from mgeo.algorithms.bit_strings import BitStrings


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
    tau : greediness, >= 0: the bit of rank k is accepted with probability ~ k^-tau; or "a-geo1"
        or "a-geo2" to let it follow the search (`mgeo.algorithms.adaptive`).
    n_walkers : number of independent walkers; `n_runs`, after the n_i re-initializations of the
        papers, is another name of it.
    bits : of each real variable, at least 2: one number for all, or one per variable. Integer
        variables take as many as their levels need.
    coding : "plain" binary numbers, or "gray" codes, where neighbors differ in one bit.
    restart : "never", or where a walker begins anew that has not advanced for `patience`
        generations: at a "random" point, or at one of the "archive".
    patience : generations without progress before a restart.
    sampling : starting points of the first walkers, rounded to the nearest string: array of up to
        (n_walkers, n_var), population or pymoo `Sampling`; the others begin with random strings.
    archive_size : largest number of points in the front, None for all of them.
    options : options of every pymoo algorithm: `termination` (5000 // n_walkers generations unless
        given), `callback`, `output`, `verbose`, `seed`, `save_history`, ...

    Raises
    ------
    TypeError, ValueError : for a parameter of the wrong type or out of range, or an unknown one.
        In a run, ValueError for a variable of one bit, which would flip in every generation.

    References
    ----------
    F. L. de Sousa, F. M. Ramos, P. Paglione, R. M. Girardi, "New stochastic algorithm for design
    optimization", AIAA Journal 41 (2003) 1808-1818 (GEO_var). I. Mainenti-Lopes, doctoral thesis,
    INPE-15384-TDI/1403 (2013), as implemented in MGEO.jl (M-GEO_var), whose codes are plain.
    """

    _evaluates_walkers = True

    def _layout(self) -> IntArray:
        if np.any(self.code.bits == 1):
            variable = int(np.argmax(self.code.bits == 1))
            raise ValueError(
                f"variable {variable} has 1 bit, which MGEOVar would flip in every generation: "
                "expected 2 or more (MGEOCanonical treats binary variables)"
            )
        return self.code.places[self.code.bits > 0]
