"""Monte Carlo: many runs of truth and estimator over one plan."""

from __future__ import annotations

import dataclasses
import warnings
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import ArrayLike

from ..environment import Environment
from ..filter.evaluator import available_threads, evaluate
from ..filter.model import FilterModel
from ..scenario import Scenario
from .draws import draw, none
from .estimator import Estimator
from .monte_carlo import MonteCarlo
from .other import other_truth
from .run import Flight, Record, simulator
from .validity import OutsideValidity, validity

#: Samples of a simulation that are kept, about.
N_RECORDS = 600


def simulate(
    scenario: Scenario,
    design: ArrayLike,
    n_runs: int = 200,
    seed: int | np.random.Generator | None = None,
    threads: int | None = None,
    *,
    estimator: Estimator | None = None,
    truth: Scenario | None = None,
    environment: Environment | None = None,
) -> MonteCarlo:
    """Fly a plan many times, each with other errors, and estimate attitude and errors from it.

    The truth is not linear: attitude by exact rotations at the plan's rates, misalignments as
    rotations, the gyro's bias as a Markov process, noise, eclipse and fields of view. At the start
    the estimator believes the body axes along GCRS and every error zero; the true ones are drawn
    from the scenario. The estimator is an error-state filter that feeds its errors back.

    A run has a random stream of its own, so it is the same whatever `n_runs` and `threads` are.

    Parameters
    ----------
    scenario : Scenario
        What the estimator believes, and from which the truth is drawn unless `truth` is given.
    design : array_like, shape (4 m,)
        Rates [deg/s] and duration [s] of each maneuver, as in `AttitudeManeuverProblem`.
    n_runs : int
    seed : int or Generator, optional
        Where the runs' streams are spawned from; None takes fresh entropy.
    threads : int, optional
        Default: the processors this process may use.
    estimator : Estimator, optional
    truth : Scenario, optional
        What is true, if it is not what the estimator believes: epoch, orbit, eclipse, gyro,
        sensors and initial uncertainty, with field and Sun, dynamics, noise and fields of view
        that follow from them. The estimator takes whatever a sensor reports. All else of the two
        must be the same.
    environment : Environment, optional
        Saves computing that of the scenario again.

    Returns
    -------
    MonteCarlo

    Warns
    -----
    OutsideValidity
        If initial errors are larger than the linear covariance was found true for; see `validity`.

    Raises
    ------
    ValueError
        For no run, several designs, a design that is no plan, a `truth` with other states or that
        differs in what it shares with the scenario, or an `environment` that is not the scenario's.
    NotImplementedError
        For a sensor that does not define `measured`.
    """
    if n_runs < 1:
        raise ValueError(f"n_runs = {n_runs!r}: expected at least 1")
    plan = np.asarray(design, dtype=float)
    if plan.ndim != 1:
        raise ValueError(f"design of shape {plan.shape}: expected one plan, shape (4 m,)")
    for reason in validity(scenario):
        warnings.warn(reason, OutsideValidity, stacklevel=2)
    environment = environment or Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    real = model if truth is None else other_truth(truth, scenario, environment)
    simulator(model.suite, real.suite)  # a sensor that cannot be simulated is found out first
    t_end = float(evaluate(model, plan[None], threads).t_end[0])
    watched = round(t_end / model.step) + 1
    expected = Flight(
        model, plan, _record_steps(model, t_end), keep_outs=scenario.keep_outs, n_watched=watched
    )
    nominal = expected.run(none(model, expected.n_steps), Estimator.plain())

    flight = expected if truth is None else dataclasses.replace(expected, truth=real)
    chosen = Estimator() if estimator is None else estimator

    def one(generator: np.random.Generator) -> Record:
        return flight.run(draw(real, flight.n_steps, generator), chosen)

    generators = np.random.default_rng(seed).spawn(n_runs)
    with ThreadPoolExecutor(max(1, min(threads or available_threads(), n_runs))) as pool:
        runs = list(pool.map(one, generators))
    return MonteCarlo(
        blocks=model.suite.blocks,
        sensors=tuple(sensor.name for sensor in model.suite.sensors),
        design=plan,
        t_end=t_end,
        times=model.times[flight.records],
        predicted=np.sqrt(nominal.variances),
        errors=np.stack([run.errors for run in runs]),
        sigma=np.sqrt(np.stack([run.variances for run in runs])),
        nees=np.stack([run.nees for run in runs]),
        nis=np.stack([run.nis for run in runs]),
        updates=np.stack([run.updates for run in runs]),
        cones=tuple(cone.name for cone in scenario.keep_outs),
        inside=np.stack([run.inside for run in runs]) / flight.n_watched,
    )


def _record_steps(model: FilterModel, t_end: float) -> np.ndarray:
    """The start, about N_RECORDS steps at equal distance, that of `t_end`, and the last."""
    stride = -(-model.n_steps // N_RECORDS)
    steps = [*range(0, model.n_steps, stride), round(t_end / model.step), model.n_steps]
    return np.unique(np.array(steps, dtype=np.int64))
