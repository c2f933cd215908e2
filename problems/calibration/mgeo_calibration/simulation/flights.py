"""Monte Carlo: many runs of truth and estimator over one plan."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.environment.directions import Cone, Passage
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.path_limits import excess
from mgeo_attitude.geometry.rotation import multiply
from mgeo_attitude.maneuvers.drives import CoilDrive
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.maneuvers.schedule import holding
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.validity import OutsideValidity, validity
from mgeo_attitude.trajectory.trajectory import Trajectory
from numpy.typing import ArrayLike

from mgeo_calibration.estimation.innovation import Estimate
from mgeo_calibration.flight.flight import Flight, draw, fly_run, moved
from mgeo_calibration.flight.own import other_truth, surroundings
from mgeo_calibration.simulation.filter import ErrorStateFilter, Estimator
from mgeo_calibration.simulation.monte_carlo import MonteCarlo, Record

#: Runs that are computed side by side, one such part after the other. In threads they would mostly
#: wait for the interpreter, which has some hundred short operations to begin in each step.
RUNS = 200

#: Samples of a simulation that are kept, about.
N_RECORDS = 600


def simulate(
    scenario: Scenario,
    design: ArrayLike,
    n_runs: int = 200,
    seed: int | np.random.Generator | None = None,
    *,
    estimator: Estimator | None = None,
    truth: Scenario | None = None,
    environment: Environment | None = None,
    until: float | None = None,
) -> MonteCarlo:
    """Fly a plan many times, each with other errors, and estimate attitude and errors from it.

    The truth is not linear: attitude by exact rotations at the plan's rates, misalignments as
    rotations, the gyro's bias as a Markov process, noise, eclipse and fields of view. At the start
    the estimator believes the scenario's attitude and every error zero; the true ones are drawn
    from the scenario. The estimator is an error-state filter that feeds its errors back.

    Coils make other rates of another attitude, so that each flight has a motion of its own, as in
    `flight.fly`; the estimator, which has the gyro's, propagates its covariance at the plan's.

    After `t_end` the last rate is held or, if the scenario asks for it, the slew back is flown and
    then the law's rate held, to the end of the scenario's duration.

    A run has a random stream of its own, so it is the same whatever `n_runs` is.

    Parameters
    ----------
    scenario : Scenario
        What the estimator believes, and from which the truth is drawn unless `truth` is given.
    design : array_like, shape (4 m,)
        Rates [deg/s] and duration [s] of each maneuver, as in `AttitudeManeuverProblem`; ``[]``
        for none.
    n_runs : int
    seed : int or Generator, optional
        Where the runs' streams are spawned from; None takes fresh entropy.
    estimator : Estimator, optional
    truth : Scenario, optional
        What is true, if it is not what the estimator believes: epoch, orbit, eclipse, gyro,
        sensors and initial uncertainty, with field and Sun, dynamics, noise and fields of view
        that follow from them. The estimator takes whatever a sensor reports; of an orbit with an
        error, where it believes that there is something to be seen. All else must be the same.
    environment : Environment, optional
        Saves computing that of the scenario again.
    until : float, optional
        Time [s] after which nothing is estimated, not before `t_end`; default: the scenario's
        duration. What is found until then does not depend on it.

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

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import simulate
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 400.0})
    >>> design = [0.5, 0.3, -0.2, 100.0, -0.3, 0.6, 0.2, 100.0, 0.2, -0.4, 0.7, 100.0]
    >>> result = simulate(scenario, design, n_runs=4, seed=1)
    >>> result.errors.shape
    (4, 401, 18)
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
    around = surroundings(truth or scenario, scenario, environment)
    plan = plan if plan.size else holding(model.initial_rate)
    t_end = float(evaluate(model, plan).t_end[0])
    whole = Trajectory(scenario, model, plan, t_end).commanded
    (variances,) = evaluate(model.endless, whole, history=True).variances
    planned = Motion.of(model, whole, model.n_steps)
    samples, n_watched = _samples(model, t_end), round(t_end / model.step) + 1
    if until is not None:
        samples = samples[model.times[samples] <= max(until, t_end)]

    def flight(generator: np.random.Generator) -> Flight:
        draws, motion = draw(real, model.n_steps, generator), planned
        if isinstance(model.slew_limits, CoilDrive):
            motion = moved(model, plan, model.n_steps, draws.errors)
        return fly_run(real, motion, draws, around)

    generators = np.random.default_rng(seed).spawn(n_runs)
    if n_runs == 1:
        generators *= 2  # NumPy adds in another order where there is one run only
    n_parts = -(-n_runs // RUNS)
    ends = [len(generators) * part // n_parts for part in range(n_parts + 1)]
    found = []
    for first, last in pairwise(ends):
        flights = [flight(generator) for generator in generators[first:last]]
        estimated = record(
            model, flights, estimator or Estimator(), samples, real, n_watched, planned.rates
        )
        found.append(vars(estimated))
    return MonteCarlo(
        blocks=model.suite.blocks,
        sensors=tuple(sensor.name for sensor in model.suite.sensors),
        numbers=tuple(len(sensor.noise()) for sensor in model.suite.sensors),
        design=plan,
        t_end=t_end,
        times=model.times[samples],
        predicted=np.sqrt(variances[samples]),
        path_limits=tuple(limit.label for limit in scenario.path_limits),
        **{key: np.concatenate([part[key] for part in found])[:n_runs] for key in found[0]},
    )


def _samples(model: FilterModel, t_end: float) -> Ints:
    """The start, about N_RECORDS steps at equal distance, that of `t_end`, and the last."""
    stride = -(-model.n_steps // N_RECORDS)
    steps = [*range(0, model.n_steps, stride), round(t_end / model.step), model.n_steps]
    return np.unique(np.array(steps, dtype=np.int64))


def record(
    model: FilterModel,
    flights: Sequence[Flight],
    estimator: Estimator,
    samples: Ints,
    real: FilterModel | None = None,
    n_watched: int = 0,
    planned_rates: Floats | None = None,
) -> Record:
    """Estimate from the readings of flights of one plan, and compare with their truth.

    Parameters
    ----------
    model : FilterModel
        What the estimator believes.
    samples : array of int
        To record, increasing; nothing is estimated after the last.
    real : FilterModel, optional
        Whose path limits are watched, along its directions, until the first `n_watched` samples.
    planned_rates : array, shape (n, 3), optional
        At which covariances are propagated [rad/s]; default: those of the first flight.
    """
    n_runs, m, suite, motion = len(flights), len(samples), model.suite, flights[0].motion
    rates = motion.rates if planned_rates is None else planned_rates
    watched = real or model
    start, states, gyro = (
        np.stack([getattr(flight, name) for flight in flights], axis=-1)
        for name in ("start", "errors", "gyro")
    )
    found = Record(
        errors=np.empty((n_runs, m, suite.n_states)),
        sigma=np.empty((n_runs, m, suite.n_states)),
        nees=np.empty((n_runs, m)),
        nis=np.zeros((n_runs, m, len(suite.sensors))),
        updates=np.zeros((n_runs, m, len(suite.sensors)), dtype=np.int64),
        broken=np.zeros((n_runs, 2, len(watched.path_limits))),
    )
    readings = [flight.readings for flight in flights]
    if suite.world.has_orbit_error:  # which moves eclipses
        readings = [each.where(model.available) for each in readings]
    estimates = ErrorStateFilter(suite, estimator).run(
        Estimate.at_start(model, n_runs),
        readings,
        rates,
        model.references,
        model.influences,
    )
    cones = [limit.cone() for limit in watched.path_limits]
    passages = [watched.passage(cone.direction, slice(n_watched)) for cone in cones]
    turns = np.vstack([np.zeros(3), model.step * rates])
    d, row = 3 + gyro.shape[1], 0
    flown = motion.attitude[..., None]
    if any(flight.motion is not motion for flight in flights):  # as those of coils
        flown = np.stack([flight.motion.attitude for flight in flights], axis=-1)
    for k, (before, after, nis) in enumerate(estimates):
        attitude = multiply(flown[k], start)
        if k < n_watched:
            off = multiply(attitude, before.rotations[:, :, 0])
            steered = multiply(off, flown[k])
            for index, (cone, passage) in enumerate(zip(cones, passages, strict=True)):
                now = passage.rows(slice(k, k + 1))
                # a controller on the estimate would have made it the plan's
                ways = [_broken(cone, turns[k], now, each) for each in (steered, attitude)]
                found.broken[:, :, index] += np.stack(ways, axis=1)
        seen = ~np.isnan(nis.T)
        found.nis[:, row] += np.where(seen, nis.T, 0.0)
        found.updates[:, row] += seen
        if k == samples[row]:
            states[3:d] = gyro[k]
            e, P = after.error(attitude, states).T, after.covariance
            found.errors[:, row], found.sigma[:, row] = e, np.sqrt(np.einsum("iir->ri", P))
            solved = np.linalg.solve(P.transpose(2, 0, 1), e[..., None])[..., 0]
            found.nees[:, row] = (e * solved).sum(axis=1)
            row += 1
            if row == m:
                break
    found.broken[:] /= max(n_watched, 1)
    return found


def _broken(cone: Cone, turn: Floats, passage: Passage, attitude: Floats) -> Bools:
    """Whether a path limit is broken in a step, shape (r,), for attitudes at its end, (3, 3, r)."""
    attitudes = np.moveaxis(attitude, -1, 0)
    seen = passage.rows(np.zeros(len(attitudes), dtype=np.int64)).seen(attitudes)
    turns, known = np.broadcast_to(turn, seen.after.shape), np.zeros((len(attitudes), 3, 3))
    bound = cone.half_angle if cone.inside else -cone.half_angle
    return excess(cone, 0.0, turns, seen, known) > bound
