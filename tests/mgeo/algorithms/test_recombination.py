"""Recombination: distribution of the children, and share of the candidates by gains."""

import numpy as np
import pytest
from pymoo.core.problem import Problem
from pymoo.problems.multi import BNH
from scipy.stats import kstest

from mgeo import MGEODirected
from mgeo.algorithms.recombination import (
    CROSSOVER_INDEX,
    MUTATION_INDEX,
    RecombinationCredit,
    recombine,
)

NONE = np.zeros(5, dtype=bool)


def test_crossover_follows_published_distribution():
    rng = np.random.default_rng(1)
    first, second = rng.random((4000, 5)), rng.random((4000, 5))
    fixed = np.zeros(5)  # Bounds without width prevent mutations.
    points = recombine(first, second, fixed, fixed, NONE, rng)
    crossed = points != first
    assert crossed.mean() == pytest.approx(0.5, abs=0.02)
    assert np.abs(np.corrcoef(crossed.T) - np.eye(5)).max() < 0.06
    factor = ((points - (first + second) / 2) / ((first - second) / 2))[crossed]
    assert (factor > 0).mean() == pytest.approx(0.5, abs=0.02)
    # Equation 13 of Deb & Agrawal 1995: half of the factors contract, and half expand.
    power = np.abs(factor) ** (CROSSOVER_INDEX + 1)
    uniform = np.where(power <= 1, power / 2, 1 - 1 / (2 * power))
    assert kstest(uniform, "uniform").pvalue > 0.01


def test_mutation_changes_one_of_n_variables_by_polynomial_law():
    rng = np.random.default_rng(2)
    xl, xu = np.array([0.0, -1.0, 0.0, 5.0, 0.0]), np.array([1.0, 1.0, 10.0, 5.5, 100.0])
    parents = np.tile(xl, (8000, 1))
    changes = (recombine(parents, parents, xl, xu, NONE, rng) - xl) / (xu - xl)
    mutated = changes != 0
    assert mutated.mean(axis=0) == pytest.approx(np.full(5, 0.2), abs=0.02)
    uniform = (1 - np.abs(changes[mutated])) ** (MUTATION_INDEX + 1)
    assert kstest(uniform, "uniform").pvalue > 0.01
    assert (changes[mutated] > 0).mean() == pytest.approx(0.5, abs=0.02)


def test_choice_is_copied_from_a_parent():
    rng = np.random.default_rng(3)
    first, second = np.full((1000, 5), 2.0), np.full((1000, 5), 7.0)
    choice = np.array([True, False, True, False, True])
    points = recombine(first, second, np.zeros(5), np.full(5, 9.0), choice, rng)[:, choice]
    assert set(points.ravel()) == {2.0, 7.0}
    assert (points == 2.0).mean() == pytest.approx(0.75, abs=0.04)


def credit_after(gain, other, generations=200):
    """Return the credit after generations in which all candidates of a kind gain the same."""
    credit, recombined = RecombinationCredit.create(8), np.arange(8) < 2
    for _ in range(generations):
        credit.update(np.where(recombined, gain, other), recombined)
    return credit


def test_share_follows_ratio_of_gains():
    for ratio, share in ((0.5, 1 / 17), (1.0, 0.2), (2.0, 0.5), (4.0, 0.8)):
        for scale in (1e-9, 1.0, 1e9):
            found = credit_after(ratio * scale, scale).compute_share(0.0, 1.0)
            assert found == pytest.approx(share, abs=1e-3)
    assert RecombinationCredit.create(48).compute_share(0.0, 1.0) == pytest.approx(0.2)


def test_share_is_clipped():
    assert credit_after(1.0, 0.0).compute_share(0.02, 0.9) == 0.9
    assert credit_after(0.0, 1.0).compute_share(0.02, 0.9) == 0.02


def test_recent_gains_have_more_weight():
    credit, recombined = credit_after(1.0, 9.0), np.arange(8) < 2
    for _ in range(100):
        credit.update(np.where(recombined, 9.0, 1.0), recombined)
    assert credit.compute_share(0.0, 1.0) > 0.9


def test_generation_of_one_kind_or_without_gains_is_ignored():
    credit, gains = RecombinationCredit.create(8), np.ones(8)
    before = credit.compute_share(0.0, 1.0)
    for gained, number in ((gains, 0), (gains, 8), (0 * gains, 4)):
        credit.update(gained, np.arange(8) < number)
    assert credit.compute_share(0.0, 1.0) == before


class Ellipsoids(Problem):
    """Two ellipsoids with a condition number of 10^4, aligned with the variables or rotated."""

    def __init__(self, rotated):
        super().__init__(n_var=10, n_obj=2, xl=-5.0, xu=5.0)
        rng = np.random.default_rng(0)
        axes = np.linalg.qr(rng.standard_normal((10, 10)))[0]
        self.axes = axes if rotated else np.eye(10)
        self.centers, self.scales = rng.uniform(-2, 2, (2, 10)), np.logspace(0, 4, 10)

    def _evaluate(self, X, out, *args, **kwargs):
        away = ((X[:, None] - self.centers) @ self.axes) ** 2
        out["F"] = away @ self.scales


def share_of_recombination(algorithm, problem, generations):
    """Return the mean share of the recombined candidates in a run."""
    run = algorithm.setup(problem, termination=("n_gen", generations), seed=1)
    found = []
    while run.has_next():
        run.next()
        found.append(run.is_recombined.mean())
    return np.mean(found)


def test_share_of_zero_disables_recombination():
    class Never(MGEODirected):
        recombination = (0.0, 0.0)

    assert share_of_recombination(Never(), BNH(), 10) == 0


def test_share_of_recombination_is_larger_for_independent_variables():
    independent, coupled = (
        share_of_recombination(MGEODirected(), Ellipsoids(rotated), 80) for rotated in (False, True)
    )
    assert independent > 1.5 * coupled
