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
from mgeo_attitude.filter.evaluator import Evaluation, available_threads, evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.geometry.rotation import matrix
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.scenario.goals import FlightErrors
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import with_noise
from mgeo_attitude.sensors.suite import Suite

#: Number of Monte Carlo runs that stay in memory, and of further runs evaluated at a time.
KEPT, _AT_ONCE = 64, 16


@dataclass(frozen=True)
class FlightSample:
    """Errors of one Monte Carlo run.

    Attributes
    ----------
    model : FilterModel
        Tables for the true initial attitude and the true start time.
    rates : array, shape (m, 3)
        Rate error of each maneuver [deg/s].
    durations : array, shape (m,)
        Duration error of each maneuver [s].
    delay : float
        Delay of the start [s].
    variants : tuple of FilterModel
        Model with the sensor noise of the run, which the filter uses too; empty for nominal noise.
    """

    model: FilterModel
    rates: Floats
    durations: Floats
    delay: float
    variants: tuple[FilterModel, ...] = ()

    def flown(self, designs: Floats) -> Floats:
        """Return designs, shape (n, 4 m), with the errors of the run; no duration is negative."""
        maneuvers = designs.reshape(-1, len(self.rates), VARIABLES_PER_MANEUVER).copy()
        maneuvers[:, :, :3] += self.rates
        maneuvers[:, :, 3] = np.maximum(maneuvers[:, :, 3] + self.durations, 0.0)
        return maneuvers.reshape(designs.shape)

    def run(self, designs: Floats, covariance: bool) -> Evaluation:
        """Evaluate designs, shape (n, 4 m), with the errors of the run, in one thread."""
        executed = self.flown(designs)
        return evaluate(self.model, executed, 1, covariance=covariance, variants=self.variants)


def draw_flights(
    scenario: Scenario,
    model: FilterModel,
    errors: FlightErrors,
    numbers: Iterable[int] | None = None,
) -> list[FlightSample]:
    """Draw Monte Carlo runs of a scenario.

    Parameters
    ----------
    scenario : Scenario
    model : FilterModel
        Model of the nominal run.
    errors : FlightErrors
    numbers : iterable of int, optional
        Numbers of the runs, which seed them. Default: all runs.

    Raises
    ------
    ValueError
        If a delayed run exceeds the validity of the field model, or a noise error is requested for
        a sensor without `noise_parameters`.
    """
    attitude, rate = errors.attitude_deg, errors.rate_error_deg_s
    root = None
    if scenario.prior is not None:
        root = np.linalg.cholesky(model.initial_covariance[:6, :6])
    attitude = scenario.initial.attitude_deg if attitude is None else attitude
    rate = scenario.gyro.initial_bias_deg_s if rate is None else rate
    flights, count = [], scenario.maneuvers.count
    for number in range(errors.count) if numbers is None else numbers:
        generator = np.random.default_rng([errors.seed, number])
        chance = generator.standard_normal(6)
        off, rates = np.radians(attitude) * chance[:3], rate * chance[3:]
        if root is not None:
            error = root @ chance
            if errors.attitude_deg is None:
                off = model.initial_attitude.T @ error[:3]
            if errors.rate_error_deg_s is None:  # An overestimated bias increases the body rate.
                rates = -np.degrees(error[3:])
        turn = matrix(off)
        rates = rates + errors.maneuver_rate_error_deg_s * generator.standard_normal((count, 3))
        durations = errors.duration_error * generator.standard_normal(count)
        delay = errors.start_delay * generator.random()
        noise = _draw_noise(scenario.suite, errors.noise_spread, generator)
        run_model = (_build_delayed_model(scenario, delay) if delay else model).turned(turn)
        variants = () if noise is None else (noise(run_model),)
        flights.append(FlightSample(run_model, rates, durations, delay, variants))
    return flights


class FlightSamples:
    """Monte Carlo runs of a scenario, in order of their numbers.

    The tables of a run take about a megabyte. The first `KEPT` runs are drawn once and stay in
    memory, since a search uses them in every generation; later runs are drawn when needed.

    Attributes
    ----------
    errors : FlightErrors
        Error model of the runs.
    """

    def __init__(self, scenario: Scenario, model: FilterModel, errors: FlightErrors) -> None:
        self._draw = partial(draw_flights, scenario, model, errors)
        self.errors = errors

    @cached_property
    def _kept(self) -> list[FlightSample]:
        return self._draw(range(min(len(self), KEPT)))

    def __len__(self) -> int:
        return self.errors.count

    def __iter__(self) -> Iterator[FlightSample]:
        return self.first(len(self))

    def first(self, count: int) -> Iterator[FlightSample]:
        """Yield the first `count` runs."""
        yield from self._kept[:count]
        for number in range(KEPT, count):
            yield from self._draw([number])


def over_flights(
    flights: Iterable[FlightSample],
    designs: Floats,
    values: Callable[[FilterModel, Evaluation], Floats],
    threads: int | None,
    covariance: bool,
) -> Floats:
    """Evaluate n designs in each of f Monte Carlo runs, shape (f, n, k).

    Runs are evaluated in parallel, with one thread each and a few in memory at a time. The result
    does not depend on the number of threads.

    Parameters
    ----------
    flights : iterable of FlightSample
    designs : array, shape (n, 4 m)
    values : function
        Returns the values, shape (n, k), for a model and an evaluation.
    threads : int, optional
        Default: the number of available processors.
    covariance : bool
        Whether to compute the covariances at the end.
    """

    def one(flight: FlightSample) -> Floats:
        return values(flight.model, flight.run(designs, covariance))

    results: list[Floats] = []
    remaining = iter(flights)
    with ThreadPoolExecutor(threads or available_threads()) as pool:
        while batch := list(islice(remaining, _AT_ONCE)):
            results += pool.map(one, batch)
    return np.array(results)


def kept_by(values: Floats, share: float) -> Floats:
    """Return the least value that is not exceeded in a share of the runs (first axis).

    NaN, from a covariance that lost positivity, counts as larger than any number.
    """
    ordered = np.sort(values, axis=0)
    value: Floats = ordered[_rank(len(values), share) - 1]
    return value


def _rank(count: int, share: float) -> int:
    """Return the rank, from 1, of the quantile `share` in `count` ascending values."""
    return max(int(np.ceil(share * count - 1e-9)), 1)


def judged(values: Floats, n_objectives: int, errors: FlightErrors) -> Floats:
    """Reduce values of Monte Carlo runs, shape (f, n, k), to one value each, shape (n, k).

    Objectives are reduced to their mean or quantile, constraints to their quantile.

    Parameters
    ----------
    values : array, shape (f, n, k)
        Objectives, then constraints.
    n_objectives : int
    errors : FlightErrors
        Specifies mean or quantiles.
    """
    objectives, limits = np.split(values, [n_objectives], axis=2)
    reduced = objectives.mean(axis=0) if errors.mean else kept_by(objectives, errors.quantile)
    return np.hstack([reduced, kept_by(limits, errors.kept)])


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
                f"flight.noise_spread: {type(part).__name__} has no noise_parameters; define them "
                "or set noise_spread = 0"
            )
    gyro, *sensors = (
        with_noise(part, float(np.exp(spread * chance)))
        for part, chance in zip(parts, generator.standard_normal(len(parts)), strict=True)
    )
    noisy = Suite(gyro, tuple(sensors), suite.world)
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
