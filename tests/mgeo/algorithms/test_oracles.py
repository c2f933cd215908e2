"""One-objective variants against published experiments: 20 walkers of 100,000 evaluations each.

docs/algorithms.md has all of them; those here, one of each way to move, are cheap, and their means
are not a matter of one or two bad runs.
"""

import numpy as np
import pytest

from mgeo import MGEOCanonical, MGEOReal, MGEOVar

from .oracles import ORACLES

HERE = {
    (MGEOReal, "range", "Ackley"),
    (MGEOCanonical, None, "Rastrigin"),
    (MGEOVar, None, "Schwefel"),
}


def here():
    """The first of each."""
    found = {}
    for oracle in ORACLES:
        key = (oracle.variant, oracle.parameters.get("perturbation"), oracle.function)
        found.setdefault(key, oracle)
    return [found[key] for key in sorted(HERE, key=str)]


ROUNDING = 1e-15  # a published zero is one of floating point


@pytest.mark.slow
@pytest.mark.parametrize("oracle", here(), ids=lambda o: f"{o.function}-{o.label}")
def test_mean_and_median_are_within_a_factor_of_two_of_the_published_ones(oracle):
    best = oracle.bests(20)
    for found, published in ((best.mean(), oracle.mean), (np.median(best), oracle.median)):
        if published < ROUNDING:
            assert found < ROUNDING
        else:
            assert 0.5 * published < found < 2.0 * published
