"""Functions that build each published variant, with parameters that differ from the defaults."""

import numpy as np

from mgeo import MGEOCanonical, MGEOReal, MGEOReal2, MGEOVar

from ..naive_walk import BitMoves, Real2Moves, RealMoves

SIGMAS = (0.1, 0.2, 0.3, 0.4, 0.5)
BITS = (3, 2, 7, 4, 5)


def real(tau=3.0, n_walkers=4, **options):
    return MGEOReal(0.7, tau, n_walkers, **options)


def real_relative(tau=1.2, n_walkers=4, **options):
    return MGEOReal(1.0, tau, n_walkers, "relative", **options)


def real_reflect(tau=2.0, n_walkers=4, **options):
    return MGEOReal(1.5, tau, n_walkers, "range", "reflect", **options)


def real_resample(tau=2.0, n_walkers=4, **options):
    return MGEOReal(0.7, tau, n_walkers, bounds="resample", **options)


def real2(tau=2.0, n_walkers=4, **options):
    return MGEOReal2(1.5, tau, n_walkers, n_steps=4, **options)


def real2_geometric(tau=0.5, n_walkers=4, **options):
    return MGEOReal2(0.3, tau, n_walkers, "range", 3, 5.0, "geometric", **options)


def real2_resample(tau=1.0, n_walkers=4, **options):
    return MGEOReal2(0.7, tau, n_walkers, "relative", 3, bounds="resample", **options)


def canonical(tau=1.0, n_walkers=4, **options):
    return MGEOCanonical(tau, n_walkers, bits=6, **options)


def canonical_gray(tau=1.0, n_walkers=4, **options):
    return MGEOCanonical(tau, n_walkers, bits=6, coding="gray", **options)


def var(tau=1.5, n_walkers=4, **options):
    return MGEOVar(tau, n_walkers, bits=6, **options)


def var_gray(tau=1.5, n_walkers=4, **options):
    return MGEOVar(tau, n_walkers, bits=6, coding="gray", **options)


VARIANTS = (
    real, real_relative, real_reflect, real_resample, real2, real2_geometric, real2_resample,
    canonical, canonical_gray, var, var_gray,
)  # fmt: skip


def build_reference_moves(algorithm, problem):
    """Return the reference implementation of an algorithm's encoding and candidates."""
    if isinstance(algorithm, MGEOReal):
        return RealMoves(problem, algorithm.sigma, algorithm.perturbation, algorithm.bounds)
    if isinstance(algorithm, MGEOReal2):
        return Real2Moves(
            problem,
            algorithm.sigma,
            algorithm.perturbation,
            algorithm.bounds,
            algorithm.n_steps,
            algorithm.divisor,
            algorithm.schedule,
        )
    return BitMoves(
        problem,
        np.array(algorithm.bits),
        algorithm.coding == "gray",
        isinstance(algorithm, MGEOVar),
    )
