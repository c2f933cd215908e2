"""Monte Carlo of the whole way: flights, their telemetry, and what is calibrated from it."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.evaluator import available_threads
from mgeo_attitude.scenario.scenario import Scenario
from numpy.typing import ArrayLike

from mgeo_calibration.calibration.from_telemetry import GATE, at_the_end
from mgeo_calibration.estimation.batch import batch
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.fit import check, settle
from mgeo_calibration.estimation.innovation import Estimate
from mgeo_calibration.estimation.residuals import filtered
from mgeo_calibration.estimation.trajectory import Trajectory
from mgeo_calibration.flight.own import fly
from mgeo_calibration.simulation.flights import Planned, planned
from mgeo_calibration.simulation.monte_carlo import MonteCarlo, Record

#: From the truth a step this small, in 1-sigmas of the constants and in rad, is the last: what it
#: leaves was found to be less than a hundredth of a 1-sigma, as the attitude hardly turns by it.
FROM_TRUTH = 10.0, 5e-3


def simulate_calibrations(
    scenario: Scenario,
    design: ArrayLike,
    n_runs: int = 200,
    seed: int | np.random.Generator | None = None,
    *,
    truth: Scenario | None = None,
    environment: Environment | None = None,
    threads: int | None = None,
) -> MonteCarlo:
    """Fly a plan many times, as `simulate` does, and calibrate from the telemetry of each flight.

    The flights are those of `simulate` with the same seed. What is estimated of each is what
    `calibrate` finds, to about a hundredth of a 1-sigma: as the truth is known, Gauss-Newton begins
    there and not with Wahba's problem. Whether `calibrate` finds its way from anywhere is no part
    of it.

    Parameters
    ----------
    scenario, design, n_runs, seed, truth, environment
        As of `simulate`.
    threads : int, optional
        Default: the processors this process may use. Results do not depend on it.

    Returns
    -------
    MonteCarlo
        Of the last sample alone, with all innovations until then. `predicted` is what the linear
        covariance of the plan promises then; path limits are not watched.

    Raises
    ------
    ValueError, NotImplementedError
        As of `simulate`, and of `calibrate` from a flight.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import simulate_calibrations
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 400.0})
    >>> design = [0.5, 0.3, -0.2, 100.0, -0.3, 0.6, 0.2, 100.0, 0.2, -0.4, 0.7, 100.0]
    >>> simulate_calibrations(scenario, design, n_runs=3, seed=1).errors.shape
    (3, 1, 18)
    """
    given = planned(scenario, design, n_runs, truth, environment)
    around = environment or Environment.from_scenario(scenario)
    run = partial(_calibrated, scenario, given, truth, around)
    generators = np.random.default_rng(seed).spawn(n_runs)
    with ThreadPoolExecutor(threads or available_threads()) as pool:
        runs = list(pool.map(run, generators))
    return given.monte_carlo(runs, np.array([given.model.n_steps]))


def _calibrated(
    scenario: Scenario,
    given: Planned,
    truth: Scenario | None,
    environment: Environment,
    generator: np.random.Generator,
) -> Record:
    """Fly once and return the errors of the calibration at the last sample."""
    telemetry = fly(scenario, given.design, generator, truth=truth, environment=environment)
    true = telemetry.truth
    assert true is not None
    data, belief = batch(scenario, telemetry), Belief.of(scenario)
    n = len(data.times)
    start = Trajectory(true.attitude[-n:].swapaxes(1, 2), true.states[-n:])
    found = settle(data, belief, start, GATE, FROM_TRUTH)
    check(found, GATE, FROM_TRUTH)
    states, P = at_the_end(belief, found)
    attitude = found.solution.estimate.attitude[-1]
    estimate = Estimate.of(data.suite, attitude[..., None], states[:, None], P)
    (e,) = estimate.error(true.attitude[-1][..., None], true.states[-1][:, None]).T
    white = filtered(found.solution).innovations
    return Record(
        errors=e[None, None],
        sigma=np.sqrt(np.diag(P))[None, None],
        nees=np.array([[e @ np.linalg.solve(P, e)]]),
        nis=np.array([[[each.nis.sum() for each in white]]]),
        updates=np.array([[[len(each.samples) for each in white]]]),
        broken=np.zeros((1, 2, 0)),
    )
