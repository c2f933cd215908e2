"""MGEO canonical: extremal optimization that flips one bit of the whole string at a time."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.sampling import Sampling

from mgeo.algorithms.acceptance import IntArray
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
    n_runs : number of independent walkers (re-initializations).
    bits : of each real variable: one number for all, or one per variable. Integer and binary
        variables take as many as their levels need.
    coding : "plain" binary numbers, or "gray" codes, where neighbors differ in one bit.
    restart : "never", or where a walker begins anew that has not advanced for `patience`
        generations: at a "random" point, or at one of the "archive".
    patience : generations without progress before a restart.
    sampling : starting points, rounded to the nearest string: (n_runs, n_var) array, population
        or pymoo `Sampling`; None for random strings. They are not evaluated themselves.
    archive_size : largest number of points in the front, None for all of them.
    options : options of every pymoo algorithm: `termination` (5000 // n_runs generations unless
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

    def __init__(
        self,
        tau: float | str = 3.0,
        n_runs: int = 30,
        bits: int | Sequence[int] = 16,
        coding: str = "plain",
        *,
        restart: str = "never",
        patience: int = 50,
        sampling: Sampling | ArrayLike | None = None,
        archive_size: int | None = None,
        **options: Any,
    ) -> None:
        super().__init__(
            tau=tau,
            n_runs=n_runs,
            bits=bits,
            coding=coding,
            restart=restart,
            patience=patience,
            sampling=sampling,
            archive_size=archive_size,
            options=options,
        )

    def _layout(self) -> IntArray:
        return np.arange(self.code.length, dtype=np.intp)[None, :]
