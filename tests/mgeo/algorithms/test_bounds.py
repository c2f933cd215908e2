"""Treatment of steps beyond the bounds: clipping, reflection and resampling."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymoo.optimize import minimize
from pymoo.problems.multi import ZDT1
from scipy.stats import cauchy, kstest, truncnorm, uniform

from mgeo import MGEODirected, MGEOReal, MGEOReal2
from mgeo.algorithms import BOUNDS, StepLaw
from mgeo.algorithms.steps import reflect, resample

NUMBER = st.floats(-1e6, 1e6)
SIZE = st.floats(0, 1e12)
START = np.full((50, 2), 0.3)


def moved(name, x, step, spread, low, high, draw=0.5):
    arrays = [np.array([float(value)]) for value in (x, step, spread, low, high)]
    return float(BOUNDS[name](*arrays, lambda: np.array([draw]))[0])


@pytest.mark.parametrize("name", BOUNDS)
@given(
    ends=st.tuples(NUMBER, NUMBER), at=st.floats(0, 1), step=st.floats(-1e12, 1e12), spread=SIZE,
    draw=st.floats(0, 1, exclude_max=True),
)  # fmt: skip
def test_treated_steps_end_inside_bounds_and_inner_steps_are_unchanged(
    name, ends, at, step, spread, draw
):
    low, high = sorted(ends)
    x = min(max(low + at * (high - low), low), high)
    found = moved(name, x, step, spread, low, high, draw)
    assert low <= found <= high
    if low <= x + step <= high:
        assert found == x + step


@given(ends=st.tuples(NUMBER, NUMBER), at=st.floats(0, 1), widths=st.floats(-40, 40))
def test_reflection_agrees_with_repeated_reflection_at_single_bounds(ends, at, widths):
    low, high = sorted(ends)
    x = min(max(low + at * (high - low), low), high)
    place = x + widths * (high - low)
    while not low <= place <= high:
        place = 2 * low - place if place < low else 2 * high - place
        if high - low < 1e-9:
            return  # Rounding errors could keep the point outside forever.
    found = moved("reflect", x, widths * (high - low), 1.0, low, high)
    assert math.isclose(found, place, abs_tol=1e-9 * max(1.0, abs(low), abs(high)))


@pytest.mark.parametrize("spread", [0.1, 0.6, 3.0, 400.0, 1e7, 1e300])
@pytest.mark.parametrize("x", [-1.0, -0.9, 0.3, 2.0])
def test_resampled_normal_steps_have_truncated_normal_distribution(x, spread):
    rng, n = np.random.default_rng(5), 20_000
    begin, box = np.full(n, x), (np.full(n, -1.0), np.full(n, 2.0))
    step = spread * rng.standard_normal(n)
    found = resample(begin, step, np.full(n, -spread), *box, lambda: rng.random(n))
    law = truncnorm((-1.0 - x) / spread, (2.0 - x) / spread, x, spread)
    if spread > 1e5:  # truncnorm loses its digits, and the law is uniform to this accuracy.
        law = uniform(-1.0, 3.0)
    assert kstest(found, law.cdf).pvalue > 1e-3


def test_resampled_steps_of_uniform_length_are_uniform_up_to_bound():
    rng, n = np.random.default_rng(6), 20_000
    begin, box = np.full(n, 0.5), (np.zeros(n), np.full(n, 2.0))
    found = resample(begin, rng.random(n) * -3.0, np.zeros(n), *box, lambda: rng.random(n))
    assert kstest(found, uniform(0.0, 0.5).cdf).pvalue > 1e-3


def test_infinite_steps_are_reflected_inside_bounds():
    x, step = np.array([0.2, 0.2, 0.0]), np.array([np.inf, -np.inf, np.inf])
    found = reflect(x, step, step, np.zeros(3), np.array([1.0, 1.0, 0.0]), x.copy)
    assert ((found >= 0) & (found <= 1)).all()


class CauchyLaw(StepLaw):
    def draw(self, stream, shape):
        return stream.standard_cauchy(shape)

    def truncated_quantile(self, probability, low, high):
        below, above = np.arctan(low), np.arctan(high)
        return np.tan(below + probability * (above - below))


class CauchyMGEO(MGEOReal):
    law = CauchyLaw()


def test_resampled_steps_follow_law_of_subclass():
    algorithm = CauchyMGEO(sigma=0.2, n_walkers=50, tau=0.0, bounds="resample", sampling=START)
    candidates = []
    minimize(
        ZDT1(n_var=2), algorithm, ("n_gen", 1), seed=1,
        callback=lambda running: candidates.append(running.pop.get("X")),
    )  # fmt: skip
    X = candidates[0]
    moved = X[START[0] != X]
    low, high = cauchy.cdf([0.0, 1.0], 0.3, 0.2)
    assert len(moved) == 100
    result = kstest(moved, lambda x: (cauchy.cdf(x, 0.3, 0.2) - low) / (high - low))
    assert result.pvalue > 1e-3


@pytest.mark.parametrize(
    "algorithm", [MGEOReal, MGEOReal2, MGEODirected], ids=lambda cls: cls.__name__
)
def test_only_clipped_steps_end_on_bounds(algorithm):
    shares = {}
    for name in BOUNDS:
        run = algorithm(n_walkers=4, bounds=name)
        seen = []
        minimize(
            ZDT1(n_var=5), run, ("n_gen", 20), seed=1,
            callback=lambda algorithm, seen=seen: seen.append(algorithm.pop.get("X")),
        )  # fmt: skip
        X = np.concatenate(seen)
        assert ((X >= 0) & (X <= 1)).all()
        shares[name] = ((X == 0) | (X == 1)).mean()
    assert shares["clip"] > 0.1
    assert shares["reflect"] == shares["resample"] == 0.0
