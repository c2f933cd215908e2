"""Evaluation of plans over Monte Carlo runs with random errors of execution and sensors.

A run has errors of the initial attitude, of rates and durations, of the start time and of the
sensor noise. The errors are applied by a `FilterModel` with rotated vectors and by a modified
design. The compiled filter is that of nominal runs, and evaluates a common initial part of several
designs only once.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import islice
from types import SimpleNamespace
from typing import Any

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.environment.times import instant_after
from mgeo_attitude.filter.evaluator import Evaluation, count_available_threads, evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.geometry.rotation import rotation_matrix
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.scenario.criteria import MonteCarloSettings
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import scale_noise
from mgeo_attitude.sensors.suite import Suite

#: Number of Monte Carlo runs that stay in memory, and number of runs evaluated at a time.
MAX_STORED_RUNS, _BATCH_SIZE = 64, 16


@dataclass(frozen=True)
class MonteCarloRun:
    """Random errors drawn for one Monte Carlo run, and the filter model of the run.

    Attributes
    ----------
    model : FilterModel
        Filter model for the true initial attitude and the true start time.
    rate_errors : array, shape (m, 3)
        Rate error of each maneuver [deg/s].
    duration_errors : array, shape (m,)
        Duration error of each maneuver [s].
    start_delay : float
        Delay of the start [s].
    variants : tuple of FilterModel
        Filter model with the sensor noise of the run, of which the filter is informed; empty for
        nominal noise.
    """

    model: FilterModel
    rate_errors: Floats
    duration_errors: Floats
    start_delay: float
    variants: tuple[FilterModel, ...] = ()

    def apply_errors(self, designs: Floats) -> Floats:
        """Add the rate and duration errors of the run to designs, shape (n, 4 m).

        Durations are at least zero.
        """
        maneuvers = designs.reshape(-1, len(self.rate_errors), VARIABLES_PER_MANEUVER).copy()
        maneuvers[:, :, :3] += self.rate_errors
        maneuvers[:, :, 3] = np.maximum(maneuvers[:, :, 3] + self.duration_errors, 0.0)
        return maneuvers.reshape(designs.shape)

    def evaluate(self, designs: Floats, covariance: bool) -> Evaluation:
        """Evaluate designs, shape (n, 4 m), with the errors of the run.

        The covariance filter runs in one thread.
        """
        executed = self.apply_errors(designs)
        return evaluate(self.model, executed, 1, covariance=covariance, variants=self.variants)


def draw_runs(
    scenario: Scenario,
    model: FilterModel,
    settings: MonteCarloSettings,
    run_numbers: Iterable[int] | None = None,
) -> list[MonteCarloRun]:
    """Draw the random errors of Monte Carlo runs, and return one `MonteCarloRun` per run number.

    Parameters
    ----------
    scenario : Scenario
    model : FilterModel
        Model of the nominal run.
    settings : MonteCarloSettings
        Distributions of the errors.
    run_numbers : iterable of int, optional
        Numbers of the runs, which seed their random numbers. Default: all runs.

    Raises
    ------
    ValueError
        If a delayed run is outside of the years of the field model, or if a noise error is
        requested for a sensor without `noise_parameters`.
    """
    attitude, rate = settings.attitude_deg, settings.rate_error_deg_s
    prior_factor = None
    if scenario.prior is not None:
        prior_factor = np.linalg.cholesky(model.initial_covariance[:6, :6])
    attitude = scenario.initial.attitude_deg if attitude is None else attitude
    rate = scenario.gyro.initial_bias_deg_s if rate is None else rate
    runs, n_maneuvers = [], scenario.maneuvers.count
    for number in range(settings.n_runs) if run_numbers is None else run_numbers:
        generator = np.random.default_rng([settings.seed, number])
        normal_numbers = generator.standard_normal(6)
        attitude_error, rate_errors = (
            np.radians(attitude) * normal_numbers[:3],
            rate * normal_numbers[3:],
        )
        if prior_factor is not None:
            error = prior_factor @ normal_numbers
            if settings.attitude_deg is None:
                attitude_error = model.initial_attitude.T @ error[:3]
            if settings.rate_error_deg_s is None:  # An overestimated bias increases the body rate.
                rate_errors = -np.degrees(error[3:])
        rotation = rotation_matrix(attitude_error)
        rate_errors = rate_errors + settings.maneuver_rate_error_deg_s * generator.standard_normal(
            (n_maneuvers, 3)
        )
        duration_errors = settings.duration_error * generator.standard_normal(n_maneuvers)
        delay = settings.start_delay * generator.random()
        apply_noise = _draw_noise(scenario.suite, settings.noise_spread, generator)
        run_model = (
            _build_delayed_model(scenario, delay) if delay else model
        ).rotate_initial_attitude(rotation)
        variants = () if apply_noise is None else (apply_noise(run_model),)
        runs.append(MonteCarloRun(run_model, rate_errors, duration_errors, delay, variants))
    return runs


class MonteCarloRuns:
    """Sequence of the Monte Carlo runs of a scenario, in the order of their numbers.

    A run takes about a megabyte. The first `MAX_STORED_RUNS` runs are drawn once and stay in
    memory, since a search uses them in every generation. Later runs are drawn when they are needed.

    Attributes
    ----------
    settings : MonteCarloSettings
        Number of runs and distributions of the errors.
    """

    def __init__(self, scenario: Scenario, model: FilterModel, errors: MonteCarloSettings) -> None:
        self._draw = partial(draw_runs, scenario, model, errors)
        self.settings = errors

    @cached_property
    def _stored_runs(self) -> list[MonteCarloRun]:
        return self._draw(range(min(len(self), MAX_STORED_RUNS)))

    def __len__(self) -> int:
        return self.settings.n_runs

    def __iter__(self) -> Iterator[MonteCarloRun]:
        return self.iterate_runs(len(self))

    def iterate_runs(self, n_runs: int) -> Iterator[MonteCarloRun]:
        yield from self._stored_runs[:n_runs]
        for number in range(MAX_STORED_RUNS, n_runs):
            yield from self._draw([number])


def evaluate_runs(
    runs: Iterable[MonteCarloRun],
    designs: Floats,
    compute_values: Callable[[FilterModel, Evaluation], Floats],
    threads: int | None,
    covariance: bool,
) -> Floats:
    """Evaluate n designs in each of several Monte Carlo runs.

    The result contains k values per run and design, shape (n_runs, n, k). Runs are evaluated in
    parallel, in one thread each, and a few runs are in memory at a time. The result does not depend
    on the number of threads.

    Parameters
    ----------
    runs : iterable of MonteCarloRun
    designs : array, shape (n, 4 m)
    compute_values : function of FilterModel and Evaluation
        Function that returns k values of each design, shape (n, k), such as objectives.
    threads : int, optional
        Default: the number of available processors.
    covariance : bool
        Whether to compute the covariances at the end.
    """

    def evaluate_run(run: MonteCarloRun) -> Floats:
        return compute_values(run.model, run.evaluate(designs, covariance))

    results: list[Floats] = []
    remaining = iter(runs)
    with ThreadPoolExecutor(threads or count_available_threads()) as pool:
        while batch := list(islice(remaining, _BATCH_SIZE)):
            results += pool.map(evaluate_run, batch)
    return np.array(results)


def compute_quantile(values: Floats, probability: float) -> Floats:
    """Return the empirical quantile of values over Monte Carlo runs, which are the first axis.

    The quantile is the smallest value that is not exceeded in the fraction `probability` of the
    runs. NaN is treated as larger than any number. It occurs if a covariance loses positive
    definiteness.
    """
    ordered = np.sort(values, axis=0)
    value: Floats = ordered[_compute_quantile_rank(len(values), probability) - 1]
    return value


def _compute_quantile_rank(n_values: int, probability: float) -> int:
    return max(int(np.ceil(probability * n_values - 1e-9)), 1)


def reduce_runs(values: Floats, n_objectives: int, settings: MonteCarloSettings) -> Floats:
    """Reduce values from several Monte Carlo runs to their means or quantiles over the runs.

    The values have the shape (n_runs, n, k), and the result has the shape (n, k). Objectives are
    reduced to their mean or quantile, constraints to their quantile.

    Parameters
    ----------
    values : array, shape (n_runs, n, k)
        Objective values, followed by constraint values.
    n_objectives : int
        Number of objectives.
    settings : MonteCarloSettings
        Choice of mean or quantiles.
    """
    objectives, constraints = np.split(values, [n_objectives], axis=2)
    reduced = (
        objectives.mean(axis=0)
        if settings.mean
        else compute_quantile(objectives, settings.quantile)
    )
    return np.hstack([reduced, compute_quantile(constraints, settings.constraint_share)])


def _draw_noise(
    suite: Suite, spread: float, generator: np.random.Generator
) -> Callable[[FilterModel], FilterModel] | None:
    """Draw random noise levels, and return a function that applies them to a filter model.

    The gyro and each sensor have a noise level of their own. Return None if `spread` is zero.
    """
    if not spread:
        return None
    parts: list[Any] = [suite.gyro, *suite.sensors]
    for part in parts:
        if not part.noise_parameters:
            raise ValueError(
                f"monte_carlo.noise_spread = {spread:g}: {type(part).__name__} has no "
                "noise_parameters; define them or set noise_spread = 0"
            )
    gyro, *sensors = (
        scale_noise(part, float(np.exp(spread * normal_number)))
        for part, normal_number in zip(parts, generator.standard_normal(len(parts)), strict=True)
    )
    noisy = Suite(gyro, tuple(sensors), suite.environment_errors)
    return lambda model: dataclasses.replace(model, suite=noisy)


def _build_delayed_model(scenario: Scenario, delay: float) -> FilterModel:
    orbit_source = SimpleNamespace(
        epoch=scenario.epoch,
        step=scenario.step,
        orbit=scenario.orbit,
        times=scenario.times + delay,
        needs_field=scenario.needs_field,
    )
    delayed, epoch = Environment.from_scenario(orbit_source), instant_after(scenario.epoch, delay)
    environment = dataclasses.replace(delayed, times=scenario.times, origin=None, epoch=epoch)
    return FilterModel.from_scenario(scenario, environment, epoch)
