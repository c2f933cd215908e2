import numpy as np
import pytest
from pymoo.algorithms.moo.nsga3 import comp_by_cv_then_random
from pymoo.algorithms.moo.unsga3 import comp_by_rank_and_ref_line_dist
from pymoo.core.population import Population
from pymoo.problems.multi import ZDT1

from mgeo.runs.pymoo_algorithms import FrontRVEA, SeededComparison
from tests.mgeo.solved import solve


@pytest.mark.parametrize("comparison", [comp_by_cv_then_random, comp_by_rank_and_ref_line_dist])
def test_comparison_without_ties_equals_that_of_pymoo(comparison):
    population = Population.new(F=np.zeros((4, 2)), G=np.array([[0.0], [0.0], [1.0], [2.0]]))
    population.set("niche", 0, "rank", 0, "dist_to_niche", 0.5)
    pairs = np.array([(a, b) for a in range(4) for b in range(4) if a != b])
    generators = [np.random.default_rng(5) for _ in range(2)]
    expected = comparison(population, pairs, random_state=generators[0])
    winners = SeededComparison(comparison)(population, pairs, random_state=generators[1])
    assert np.array_equal(winners, expected)


def test_rvea_uses_its_whole_budget():
    directions = np.column_stack([np.linspace(0, 1, 10), np.linspace(1, 0, 10)])
    assert solve(ZDT1(n_var=4), FrontRVEA(directions), 95, seed=1).n_evaluations == 100
