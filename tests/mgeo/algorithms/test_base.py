"""`check_algorithm` for every variant."""

import pytest
from pymoo.operators.sampling.lhs import LHS

from mgeo import MGEODirected, MGEOReal, MGEOStaged
from mgeo.testing import check_algorithm

from .variants import VARIANTS, canonical, real, real2, var

ADAPTIVE = {"tau": "a-geo2", "restart": "archive", "patience": 1}


class Learning(MGEODirected):
    adaptation_delay = 30


class AlwaysAttracted(MGEODirected):
    coupling, sigma_range, return_probability, migration_probability = (
        (0.0, 1.0),
        (0.1, 0.1),
        1.0,
        (0.0, 0.0),
    )


@pytest.mark.cases(4)
@pytest.mark.parametrize(
    "algorithm",
    [
        real(n_walkers=3, **ADAPTIVE),
        canonical(n_walkers=3),
        MGEODirected(),
        MGEOStaged(fidelity_schedule=(0.0, 1.0), n_walkers=3, archive_size=9),
        *(variant(n_walkers=3, **ADAPTIVE) for variant in VARIANTS[1:]),
        real2(n_walkers=3),
        var(n_walkers=3),
        MGEOReal([0.5, 1.0, 0.1, 2.0], 1.0, 2, "range", archive_size=10),
        MGEOReal(0.5, n_walkers=4, perturbation="relative", sampling=LHS()),
        MGEODirected(n_walkers=3, extreme_weights=1.0, archive_size=10),
        MGEODirected(difference=(0.65, 0.65), momentum=(0.0, 0.0)),
        AlwaysAttracted(1.0, 6, 0.0, (1.0, 1.0), max_candidates=2),
        Learning(n_walkers=6),
    ],
    ids=lambda algorithm: type(algorithm).__name__,
)
def test_every_variant_passes_check_algorithm(algorithm):
    check_algorithm(algorithm)
