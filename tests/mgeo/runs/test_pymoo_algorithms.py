import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.problems.multi import ZDT1
from pymoo.util.archive import MultiObjectiveArchive, RandomTruncation, Truncation

from mgeo.runs.operators import set_up
from mgeo.runs.pymoo_algorithms import FrontRVEA
from tests.mgeo.solved import solve


class Last(Truncation):
    def __call__(self, sols, k):
        return sols[-k:]


def archived(seed, truncation):
    archive = MultiObjectiveArchive(max_size=6, truncate_size=4, truncation=truncation)
    algorithm = set_up(ZDT1(n_var=4), NSGA2(pop_size=20, archive=archive), 400, seed)
    algorithm.run()
    return algorithm.archive.get("F")


@pytest.mark.parametrize("truncation", [RandomTruncation(), Last()])
def test_an_archive_that_pymoo_truncates_repeats_with_the_seed(truncation):
    found = archived(1, truncation)
    assert 0 < len(found) <= 6
    assert np.array_equal(found, archived(1, truncation))
    assert not np.array_equal(found, archived(2, truncation))


def test_rvea_makes_all_generations_of_its_budget_and_returns_a_front():
    directions = np.column_stack([np.linspace(0, 1, 10), np.linspace(1, 0, 10)])
    outcome = solve(ZDT1(n_var=4), FrontRVEA(directions), 95, seed=1)
    assert outcome.evaluations == 100
    by_generations = set_up(ZDT1(n_var=4), FrontRVEA(directions), 95, seed=1)
    by_generations.setup(ZDT1(n_var=4), termination=("n_gen", 3), seed=1)
    by_generations.run()
    assert by_generations.evaluator.n_eval == 30
