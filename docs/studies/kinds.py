"""Figures of the kinds of candidates of `MGEODirected`, in two variables, for the page on the
MGEO family.

The archive consists of eleven points along a curved valley, and the walker is near the valley. All
candidates come from the functions that the algorithm uses.
"""

import numpy as np
from family import draw_kind

from mgeo import MGEODirected
from mgeo.algorithms.moves import Attraction, draw_joint_steps, draw_momentum_steps
from mgeo.algorithms.recombination import recombine

NUMBER = 600
WALKER, BEST, BEFORE = np.array([0.55, 0.62]), np.array([0.5, 0.55]), np.array([-0.08, -0.05])
ALONG = np.linspace(0.15, 0.85, 11)
ARCHIVE = np.column_stack([ALONG, 0.25 + 0.8 * (ALONG - 0.35) ** 2])
NEAREST = ARCHIVE[5]
LOW, HIGH = np.zeros(2), np.ones(2)


def normal_steps(rng):
    """Return the end points of normal steps, which change mostly one variable."""
    primary, cls = rng.integers(2, size=NUMBER), MGEODirected
    steps, _, _ = draw_joint_steps(primary, HIGH, cls.sigma_range, cls.coupling, 0.0, None, rng)
    return WALKER + steps


def differences(rng):
    """Return the end points of difference steps, half of them attracted to the nearest point."""
    primary, cls = rng.integers(2, size=NUMBER), MGEODirected
    share, coupling = cls.attraction
    attraction = Attraction(share, coupling, WALKER, NEAREST)
    steps, _, _ = draw_joint_steps(
        primary,
        HIGH,
        cls.sigma_range,
        cls.coupling,
        1.0,
        lambda shape: draw_pairs(shape, rng),
        rng,
        attraction,
    )
    return WALKER + steps


def draw_pairs(shape, rng):
    """Return random pairs of archived points as two arrays."""
    first, second = rng.integers(len(ARCHIVE), size=(2, *shape))
    return ARCHIVE[first], ARCHIVE[second]


def momentum(rng):
    """Return the end points of steps with momentum towards a point of the archive."""
    return WALKER + draw_momentum_steps(WALKER, BEFORE, np.tile(NEAREST, (NUMBER, 1)), HIGH, rng)


def recombinations(rng):
    """Return children of the walker's best or nearest point and another archived point."""
    first = np.where(rng.random((NUMBER, 1)) < 0.5, NEAREST, BEST)
    second = ARCHIVE[rng.integers(len(ARCHIVE), size=NUMBER)]
    return recombine(first, second, LOW, HIGH, np.zeros(2, dtype=bool), rng)


def kind_figure(candidates):
    """Return a scatter plot of the candidates that one of the functions above draws."""
    X = np.clip(candidates(np.random.default_rng(1)), LOW, HIGH)
    points = {
        "archive": ARCHIVE,
        "nearest archived point": NEAREST,
        "walker": WALKER,
        "best point of the walker": BEST,
    }
    return draw_kind(X, points)
