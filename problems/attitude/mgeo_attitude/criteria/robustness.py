"""Evaluation of plans over Monte Carlo runs with execution errors and sensor errors.

A run has another initial attitude, other rates and durations, a delayed start, or other sensor
noise. Each run is a `FilterModel` with rotated tables and a modified design. The kernel is the
same, and designs of a run share common initial parts as in nominal runs.
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

#: Number of Monte Carlo runs that stay in memory, and of further runs evaluated at a time.
MAX_STORED_RUNS, _BATCH_SIZE = 64, 16


@dataclass(frozen=True)
class MonteCarloRun:
    """Errors of one Monte Carlo run.

    Attributes
    ----------
    model : FilterModel
        Tables for the true initial attitude and the true start time.
    rate_errors : array, shape (m, 3)
        Rate error of each maneuver [deg/s].
    duration_errors : array, shape (m,)
        Duration error of each maneuver [s].
    start_delay : float
        Delay of the start [s].
    variants : tuple of FilterModel
        Model with the sensor noise of the run, which the filter uses too; empty for nominal noise.
    """

    model: FilterModel
    rate_errors: Floats
    duration_errors: Floats
    start_delay: float
    variants: tuple[FilterModel, ...] = ()

    def apply_errors(self, designs: Floats) -> Floats:
        """Return designs, shape (n, 4 m), with the errors of the run; no duration is negative."""
        maneuvers = designs.reshape(-1, len(self.rate_errors), VARIABLES_PER_MANEUVER).copy()
        maneuvers[:, :, :3] += self.rate_errors
        maneuvers[:, :, 3] = np.maximum(maneuvers[:, :, 3] + self.duration_errors, 0.0)
        return maneuvers.reshape(designs.shape)

    def evaluate(self, designs: Floats, covariance: bool) -> Evaluation:
        """Evaluate designs, shape (n, 4 m), with the errors of the run, in one thread."""
        executed = self.apply_errors(designs)
        return evaluate(self.model, executed, 1, covariance=covariance, variants=self.variants)


def draw_runs(
    scenario: Scenario,
    model: FilterModel,
    settings: MonteCarloSettings,
    run_numbers: Iterable[int] | None = None,
) -> list[MonteCarloRun]:
    """Draw Monte Carlo runs of a scenario.

    Parameters
    ----------
    scenario : Scenario
    model : FilterModel
        Model of the nominal run.
    settings : MonteCarloSettings
    run_numbers : iterable of int, optional
        Numbers of the runs, which seed them. Default: all runs.

    Raises
    ------
    ValueError
        If a delayed run exceeds the validity of the field model, or a noise error is requested for
        a sensor without `noise_parameters`.
    """
    attitude, rate = settings.attitude_deg, settings.rate_error_deg_s
    root = None
    if scenario.prior is not None:
        root = np.linalg.cholesky(model.initial_covariance[:6, :6])
    attitude = scenario.initial.attitude_deg if attitude is None else attitude
    rate = scenario.gyro.initial_bias_deg_s if rate is None else rate
    flights, count = [], scenario.maneuvers.count
    for number in range(settings.n_runs) if run_numbers is None else run_numbers:
        generator = np.random.default_rng([settings.seed, number])
        chance = generator.standard_normal(6)
        off, rates = np.radians(attitude) * chance[:3], rate * chance[3:]
        if root is not None:
            error = root @ chance
            if settings.attitude_deg is None:
                off = model.initial_attitude.T @ error[:3]
            if settings.rate_error_deg_s is None:  # An overestimated bias increases the body rate.
                rates = -np.degrees(error[3:])
        turn = rotation_matrix(off)
        rates = rates + settings.maneuver_rate_error_deg_s * generator.standard_normal((count, 3))
        durations = settings.duration_error * generator.standard_normal(count)
        delay = settings.start_delay * generator.random()
        noise = _draw_noise(scenario.suite, settings.noise_spread, generator)
        run_model = (
            _build_delayed_model(scenario, delay) if delay else model
        ).rotate_initial_attitude(turn)
        variants = () if noise is None else (noise(run_model),)
        flights.append(MonteCarloRun(run_model, rates, durations, delay, variants))
    return flights


class MonteCarloRuns:
    """Monte Carlo runs of a scenario, in order of their numbers.

    The tables of a run take about a megabyte. The first `KEPT` runs are drawn once and stay in
    memory, since a search uses them in every generation; later runs are drawn when needed.

    Attributes
    ----------
    errors : MonteCarloSettings
        Error model of the runs.
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
        """Yield the first `n_runs` runs."""
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
    """Evaluate n designs in each of f Monte Carlo runs, shape (f, n, k).

    Runs are evaluated in parallel, with one thread each and a few in memory at a time. The result
    does not depend on the number of threads.

    Parameters
    ----------
    runs : iterable of MonteCarloRun
    designs : array, shape (n, 4 m)
    compute_values : function
        Returns the values, shape (n, k), for a model and an evaluation.
    threads : int, optional
        Default: the number of available processors.
    covariance : bool
        Whether to compute the covariances at the end.
    """

    def one(flight: MonteCarloRun) -> Floats:
        return compute_values(flight.model, flight.evaluate(designs, covariance))

    results: list[Floats] = []
    remaining = iter(runs)
    with ThreadPoolExecutor(threads or count_available_threads()) as pool:
        while batch := list(islice(remaining, _BATCH_SIZE)):
            results += pool.map(one, batch)
    return np.array(results)


def compute_quantile(values: Floats, probability: float) -> Floats:
    """Return the least value that is not exceeded in a share of the runs (first axis).

    NaN, from a covariance that lost positivity, counts as larger than any number.
    """
    ordered = np.sort(values, axis=0)
    value: Floats = ordered[_compute_quantile_rank(len(values), probability) - 1]
    return value


def _compute_quantile_rank(n_values: int, probability: float) -> int:
    """Return the rank, from 1, of the quantile `probability` in `n_values` ascending values."""
    return max(int(np.ceil(probability * n_values - 1e-9)), 1)


def reduce_runs(values: Floats, n_objectives: int, settings: MonteCarloSettings) -> Floats:
    """Reduce values of Monte Carlo runs, shape (f, n, k), to one value each, shape (n, k).

    Objectives are reduced to their mean or quantile, constraints to their quantile.

    Parameters
    ----------
    values : array, shape (f, n, k)
        Objectives, then constraints.
    n_objectives : int
    settings : MonteCarloSettings
        Specifies mean or quantiles.
    """
    objectives, limits = np.split(values, [n_objectives], axis=2)
    reduced = (
        objectives.mean(axis=0)
        if settings.mean
        else compute_quantile(objectives, settings.quantile)
    )
    return np.hstack([reduced, compute_quantile(limits, settings.constraint_share)])


def _draw_noise(
    suite: Suite, spread: float, generator: np.random.Generator
) -> Callable[[FilterModel], FilterModel] | None:
    """Draw noise errors and return a function that applies them to a model; None without errors."""
    if not spread:
        return None
    parts: list[Any] = [suite.gyro, *suite.sensors]
    for part in parts:
        if not part.noise_parameters:
            raise ValueError(
                f"monte_carlo.noise_spread: {type(part).__name__} has no noise_parameters; define them "
                "or set noise_spread = 0"
            )
    gyro, *sensors = (
        scale_noise(part, float(np.exp(spread * chance)))
        for part, chance in zip(parts, generator.standard_normal(len(parts)), strict=True)
    )
    noisy = Suite(gyro, tuple(sensors), suite.environment_errors)
    return lambda model: dataclasses.replace(model, suite=noisy)


def _build_delayed_model(scenario: Scenario, delay: float) -> FilterModel:
    course = SimpleNamespace(
        epoch=scenario.epoch,
        step=scenario.step,
        orbit=scenario.orbit,
        times=scenario.times + delay,
        needs_field=scenario.needs_field,
    )
    tables, epoch = Environment.from_scenario(course), instant_after(scenario.epoch, delay)
    around = dataclasses.replace(tables, times=scenario.times, origin=None, epoch=epoch)
    return FilterModel.from_scenario(scenario, around, epoch)
