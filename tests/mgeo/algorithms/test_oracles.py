"""Single-objective variants agree with published results, with 20 runs of 100,000 evaluations.

docs/explanation/algorithms.md compares all published results. The tests use one result per kind of
step, which is cheap to compute and whose mean does not depend on one or two bad runs.
"""

import numpy as np
import pytest

from mgeo import MGEOCanonical, MGEOReal, MGEOVar

from .oracles import ORACLES

SELECTED = {
    (MGEOReal, "range", "Ackley"),
    (MGEOCanonical, None, "Rastrigin"),
    (MGEOVar, None, "Schwefel"),
}


def select_oracles():
    """Return the first published result of each selected variant and function."""
    first = {}
    for oracle in ORACLES:
        key = (oracle.variant, oracle.parameters.get("perturbation"), oracle.function)
        first.setdefault(key, oracle)
    return [first[key] for key in sorted(SELECTED, key=str)]


#: Rounding error of a published zero.
ROUNDING = 1e-15


@pytest.mark.slow
@pytest.mark.parametrize("oracle", select_oracles(), ids=lambda o: f"{o.function}-{o.label}")
def test_mean_and_median_are_within_factor_two_of_published_values(oracle):
    best = oracle.bests(20)
    for found, published in ((best.mean(), oracle.mean), (np.median(best), oracle.median)):
        if published < ROUNDING:
            assert found < ROUNDING
        else:
            assert 0.5 * published < found < 2.0 * published
