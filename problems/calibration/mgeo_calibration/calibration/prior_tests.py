"""Whether what was estimated is what was believed before."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Floats
from scipy.stats import chi2

from mgeo_calibration.estimation.belief import Belief

#: Name of the test of all states together.
ALL = "all"


@dataclass(frozen=True, kw_only=True)
class PriorTest:
    """Test of an estimate x against what was believed, x0 with the covariance P0.

    Attributes
    ----------
    block : str
        Of states, or `ALL`.
    chi_square : float
        (x - x0)ᵀ P0⁻¹ (x - x0), at the first sample. Where readings say nothing it is zero: chance
        exceeds a bound less often than a chi-square distribution says.
    freedom : int
        Its degrees of freedom.
    sigmas : float
        Largest difference of a state over its 1-sigma before.
    p : float
        Probability that chance exceeds it, at most.
    p_least : float
        The test fails below this.
    """

    block: str
    chi_square: float
    freedom: int
    sigmas: float
    p: float
    p_least: float

    @property
    def fails(self) -> bool:
        """Whether chance hardly explains it."""
        return self.p < self.p_least

    @property
    def words(self) -> str:
        """By how much it is off."""
        p = f"p = {self.p:.1g}" if self.p > 1e-300 else "p < 1e-300"
        off = f"(chi-square {self.chi_square:.4g} of {self.freedom}, {p})"
        if self.block == ALL:
            return f"the estimate is not what was believed before {off}"
        return f"{self.block} is {self.sigmas:.3g} of its prior 1-sigmas from the prior {off}"


def contradictions(tests: Iterable[PriorTest]) -> list[tuple[float, str]]:
    """Chi-squares of what does not hold, and words: blocks, or all if it is none of them."""
    failed = [test for test in tests if test.fails]
    blocks = [test for test in failed if test.block != ALL]
    return [(test.chi_square, test.words) for test in blocks or failed]


def number_of_tests(belief: Belief) -> int:
    """One for each block of which something is believed, and one for all."""
    return len(_blocks(belief)) + 1


def prior_tests(
    belief: Belief, attitude: Floats, states: Floats, p_least: float
) -> tuple[PriorTest, ...]:
    """Of all states and of each block, of an estimate at the first sample.

    Parameters
    ----------
    attitude : array, shape (3, 3)
        Body to GCRS.
    states : array, shape (n_states,)
    """
    off = belief.difference(attitude, states)
    made = []
    for name, block in {ALL: slice(None), **_blocks(belief)}.items():
        x = off[block] / belief.sigma[block]
        square = float(x @ np.linalg.solve(belief.correlation[block, block], x))
        freedom = len(x) if name != ALL else sum(len(off[b]) for b in _blocks(belief).values())
        made.append(
            PriorTest(
                block=name,
                chi_square=square,
                freedom=freedom,
                sigmas=float(np.abs(x).max()),
                p=float(chi2.sf(square, freedom)),
                p_least=p_least,
            )
        )
    return tuple(made)


def _blocks(belief: Belief) -> dict[str, slice]:
    """Those of which something is believed, by name."""
    named = {name: slice(3 * i, 3 * i + 3) for i, name in enumerate(belief.suite.blocks)}
    if belief.attitude is None:
        del named["attitude"]
    return named
