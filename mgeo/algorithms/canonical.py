"""MGEO canonical: extremal optimization that flips one bit of the whole string at a time."""

import numpy as np

from mgeo._typing import IntArray
from mgeo.algorithms.bit_strings import BitStrings


class MGEOCanonical(BitStrings):
    """Multiobjective generalized extremal optimization on strings of bits (M-GEO).

    In every generation each bit of each walker gives one candidate, in which that bit alone is
    flipped; one of them is accepted. A generation therefore costs as many evaluations as all
    strings have bits. With one objective it is GEO.

    Parameters
    ----------
    tau : greediness, >= 0: the candidate of rank k is accepted with probability ~ k^-tau; or
        "a-geo1" or "a-geo2" to let it follow the search (`mgeo.algorithms.adaptive`).
    n_walkers : number of independent walkers; `n_runs`, after the n_i re-initializations of the
        papers, is another name of it.
    bits : of each real variable: one number for all, or one per variable. Integer and binary
        variables take as many as their levels need.
    coding : "plain" binary numbers, or "gray" codes, where neighbors differ in one bit.
    restart : "never", or where a walker begins anew that has not advanced for `patience`
        generations: at a "random" point, or at one of the "archive".
    patience : generations without progress before a restart.
    sampling : starting points of the first walkers, rounded to the nearest string: array of up to
        (n_walkers, n_var), population or pymoo `Sampling`; the others begin with random strings.
        Starting points are not evaluated themselves.
    archive_size : largest number of points in the front, None for all of them.
    options : options of every pymoo algorithm: `termination` (5000 // n_walkers generations unless
        given), `callback`, `output`, `verbose`, `seed`, `save_history`, ...

    Raises
    ------
    TypeError, ValueError : for a parameter of the wrong type or out of range, or an unknown one.

    References
    ----------
    F. L. de Sousa, F. M. Ramos, P. Paglione, R. M. Girardi, "New stochastic algorithm for design
    optimization", AIAA Journal 41 (2003) 1808-1818 (GEO). R. L. Galski, doctoral thesis,
    INPE-14795-TDI/1238 (2006) (M-GEO), as implemented in MGEO.jl, whose codes are plain.
    """

    def _layout(self) -> IntArray:
        return np.arange(self.code.length, dtype=np.intp)[None, :]
