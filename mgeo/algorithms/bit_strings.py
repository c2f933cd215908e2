"""What the members with strings of bits share: the code, and that a candidate flips one bit."""

from abc import ABC
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.problem import Problem
from pymoo.core.sampling import Sampling

from mgeo._typing import FloatArray
from mgeo._validation import validate_choice, validate_each, validate_integer
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.coding import MOST_BITS, BitCode
from mgeo.algorithms.constructors import takes_n_runs
from mgeo.algorithms.variables import Variables

CODINGS = ("plain", "gray")


class BitStrings(ExtremalOptimization, ABC):
    """Extremal optimization whose walkers are strings of bits; a leaf says how they are grouped.

    Parameters
    ----------
    tau, n_walkers, restart, patience, archive_size, options : as for `ExtremalOptimization`.
    bits : of each real variable, 1 to 52: one number for all, or one per variable. Integer and
        binary variables take as many as their levels need.
    coding : "plain" binary numbers, or "gray" codes, where neighbors differ in one bit.
    sampling : starting points of the first walkers, rounded to the nearest string: array of up to
        (n_walkers, n_var), population or pymoo `Sampling`; the others begin with random strings.
    """

    @takes_n_runs
    def __init__(
        self,
        tau: float | str = 3.0,
        n_walkers: int = 30,
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
            n_walkers=n_walkers,
            restart=restart,
            patience=patience,
            sampling=sampling,
            archive_size=archive_size,
            options=options,
        )
        self.bits = validate_each("bits", bits, validate_integer, low=1, high=MOST_BITS)
        self.coding = validate_choice("coding", coding, CODINGS)
        self.code: BitCode

    def _variables(self, problem: Problem) -> Variables:
        variables = Variables.of(problem, ("real", "integer", "binary"))
        self.code = BitCode.of(variables, self.bits, self.coding == "gray")
        return variables

    def _draw(self, streams: Sequence[np.random.Generator]) -> FloatArray:
        length = self.code.length
        return np.array([stream.integers(0, 2, length) for stream in streams], dtype=float)

    def _propose(self) -> FloatArray:
        return 1.0 - self.walkers[:, self._coordinates]

    def _decode(self, points: FloatArray) -> FloatArray:
        return self.code.decode(points)

    def _encode(self, values: FloatArray) -> FloatArray:
        return self.code.encode(values)
