"""Monte Carlo of the whole way: flights, their telemetry, and what is calibrated from it."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.calibration.from_telemetry import GATE, at_the_end
from mgeo_attitude.environment import Environment
from mgeo_attitude.estimation.batch import Batch
from mgeo_attitude.estimation.belief import Belief
from mgeo_attitude.estimation.estimate import Estimate
from mgeo_attitude.estimation.fit import check, settle
from mgeo_attitude.estimation.linearization import Trajectory
from mgeo_attitude.estimation.monte_carlo import MonteCarlo
from mgeo_attitude.estimation.residuals import innovations
from mgeo_attitude.estimation.simulate import Planned, planned
from mgeo_attitude.filter.evaluator import available_threads
from mgeo_attitude.flight import Flight, draw, fly_run
from mgeo_attitude.flight.simulated import true_states
from mgeo_attitude.rotation import matrix
from mgeo_attitude.scenario import Scenario

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
    """
    given = planned(scenario, design, n_runs, truth, environment)
    generators = np.random.default_rng(seed).spawn(n_runs)
    with ThreadPoolExecutor(threads or available_threads()) as pool:
        runs = list(pool.map(partial(_calibrated, scenario, given), generators))
    n = given.model.n_steps
    return MonteCarlo(
        blocks=given.model.suite.blocks,
        sensors=tuple(sensor.name for sensor in given.model.suite.sensors),
        design=given.design,
        t_end=given.t_end,
        times=given.model.times[n:],
        predicted=np.sqrt(given.variances[n:]),
        errors=np.stack([run.error for run in runs])[:, None],
        sigma=np.stack([run.sigma for run in runs])[:, None],
        nees=np.array([[run.nees] for run in runs]),
        nis=np.stack([run.nis for run in runs])[:, None],
        updates=np.stack([run.updates for run in runs])[:, None],
        path_limits=(),
        broken=np.zeros((n_runs, 2, 0)),
    )


@dataclass(frozen=True, eq=False)
class _Run:
    error: Floats
    sigma: Floats
    nees: float
    nis: Floats
    updates: Ints


def _batch(scenario: Scenario, given: Planned, flight: Flight) -> Batch:
    """What `estimation.batch` makes of the flight's telemetry, without the way through its units.

    Nothing is reported at the start, so that the first sample is the second, unless an earlier
    calibration says what is known at the start.
    """
    model, first = given.model, 0 if scenario.prior else 1
    rates = flight.readings.gyro[first:]
    return Batch(
        suite=model.suite,
        times=model.times[first:],
        gyro=rates,
        interpolated=np.zeros(len(rates)),
        breaks=np.zeros(len(rates), dtype=bool),
        sensors=tuple(
            np.where(model.available[first:, index, None, None], rows[first:], np.nan)
            for index, rows in enumerate(flight.readings.sensors)
        ),
        vectors=model.references[first:],
    )


def _calibrated(scenario: Scenario, given: Planned, generator: np.random.Generator) -> _Run:
    """One flight, and its calibration against its truth."""
    drawn = draw(given.real, given.model.n_steps, generator)
    flight = fly_run(given.real, given.motion, drawn)
    data, belief = _batch(scenario, given, flight), Belief.of(scenario)
    true = true_states(given.real, flight)
    start = Trajectory(
        true.attitude[-len(data.times) :].swapaxes(1, 2), true.states[-len(data.times) :]
    )
    found = settle(data, belief, start, GATE, FROM_TRUTH)
    check(found, GATE, FROM_TRUTH)
    states, P = at_the_end(belief, found)
    places = np.arange(3)[:, None] + np.array(data.suite.rotations)
    rotations, states = matrix(states[places])[..., None], states[:, None].copy()
    rotations[:, :, 0, 0] = found.solution.estimate.attitude[-1]
    states[places] = 0.0
    estimate = Estimate(places, rotations, states, P)
    (e,) = estimate.error(true.attitude[-1][..., None], true.states[-1][:, None]).T
    white = innovations(found.solution)
    return _Run(
        error=e,
        sigma=np.sqrt(np.diag(P)),
        nees=float(e @ np.linalg.solve(P, e)),
        nis=np.array([each.nis.sum() for each in white]),
        updates=np.array([len(each.samples) for each in white]),
    )
