import numpy as np
import pytest
from scipy.stats import kstest

from mgeo.algorithms.steps import SCALES, clip
from mgeo.algorithms.steps import perturb as perturb_within


def perturb(*arguments):
    return perturb_within(*arguments, clip, np.random.default_rng(0).random)


XL, XU = np.array([-1e4, -1e4, 0.0]), np.array([1e4, 1e4, 0.0])


@pytest.mark.parametrize(
    ("perturbation", "deviations"),
    [("absolute", [0.5, 0.5]), ("relative", [2.0, 0.5]), ("range", [1000.0, 1000.0])],
)
def test_standard_deviation_of_steps_has_requested_unit(perturbation, deviations):
    x = np.tile([-4.0, 1.0, 0.0], (50_000, 1))
    noise = np.random.default_rng(0).standard_normal(x.shape)
    sigma = np.array([0.5, 0.5, 0.5]) if perturbation != "range" else 0.05
    step = perturb(x, noise, sigma, SCALES[perturbation], XL, XU) - x
    assert step[:, :2].std(axis=0) == pytest.approx(deviations, rel=0.02)
    assert not step[:, 2].any()  # A variable with equal bounds is constant.


def test_steps_inside_bounds_are_normal():
    x = np.zeros((20_000, 1))
    noise = np.random.default_rng(1).standard_normal(x.shape)
    step = perturb(x, noise, 0.1, SCALES["range"], np.array([-5.0]), np.array([5.0]))
    assert kstest(step.ravel(), "norm").pvalue > 1e-3


def test_only_relative_steps_leave_zero_unchanged():
    x, noise, bounds = np.zeros((1, 1)), np.ones((1, 1)), (np.array([-1.0]), np.array([1.0]))
    values = {name: perturb(x, noise, 0.5, scale, *bounds)[0, 0] for name, scale in SCALES.items()}
    assert values == {"absolute": 0.5, "relative": 0.0, "range": 1.0}
