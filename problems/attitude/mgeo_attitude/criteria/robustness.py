"""Plans judged over flights: what they keep when they are not flown exactly.

A flight starts from another attitude, turns at other rates for other times, begins later than
planned, or has sensors of other noise. Each is a `FilterModel` with turned tables and a changed
design, so that the filter's kernel is the same, and designs share what they begin with as ever.
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

#: Flights of a scenario that stay in memory, and those that are there together besides.
KEPT, _AT_ONCE = 64, 16


@dataclass(frozen=True)
class FlightSample:
    """One way in which plans are flown.

    Attributes
    ----------
    model : FilterModel
        Tables from the true attitude at the start, at the true time.
    rates : array, shape (m, 3)
        Added to the rate of each maneuver [deg/s].
    durations : array, shape (m,)
        Added to its duration [s].
    delay : float
        Of the start [s].
    variants : tuple of FilterModel
        The model with the noise of this flight, which its filter knows; none if it is as believed.
    """

    model: FilterModel
    rates: Floats
    durations: Floats
    delay: float
    variants: tuple[FilterModel, ...] = ()

    def flown(self, designs: Floats) -> Floats:
        """What becomes of designs, shape (n, 4 m); a duration below zero is none."""
        maneuvers = designs.reshape(-1, len(self.rates), VARIABLES_PER_MANEUVER).copy()
        maneuvers[:, :, :3] += self.rates
        maneuvers[:, :, 3] = np.maximum(maneuvers[:, :, 3] + self.durations, 0.0)
        return maneuvers.reshape(designs.shape)

    def run(self, designs: Floats, covariance: bool) -> Evaluation:
        """What the filter makes of designs in this flight, in one thread."""
        flown = self.flown(designs)
        return evaluate(self.model, flown, 1, covariance=covariance, variants=self.variants)


def draw_flights(
    scenario: Scenario,
    model: FilterModel,
    errors: FlightErrors,
    numbers: Iterable[int] | None = None,
) -> list[FlightSample]:
    """Draw the flights of a scenario whose exact one is `model`, or those of some numbers.

    Raises
    ------
    ValueError
        If a delayed run leaves the years of the field model, or noise should be other than believed
        of a sensor that does not say which of its parameters are.
    """
    attitude, rate = errors.attitude_deg, errors.rate_error_deg_s
    known = None
    if scenario.prior is not None:
        known = np.linalg.cholesky(model.initial_covariance[:6, :6])
    attitude = scenario.initial.attitude_deg if attitude is None else attitude
    rate = scenario.gyro.initial_bias_deg_s if rate is None else rate
    flights, count = [], scenario.maneuvers.count
    for number in range(errors.count) if numbers is None else numbers:
        generator = np.random.default_rng([errors.seed, number])
        chance = generator.standard_normal(6)
        off, rates = np.radians(attitude) * chance[:3], rate * chance[3:]
        if known is not None:
            error = known @ chance
            if errors.attitude_deg is None:
                off = model.initial_attitude.T @ error[:3]
            if errors.rate_error_deg_s is None:  # who believes in too large a bias turns too fast
                rates = -np.degrees(error[3:])
        turn = matrix(off)
        rates = rates + errors.maneuver_rate_error_deg_s * generator.standard_normal((count, 3))
        durations = errors.duration_error * generator.standard_normal(count)
        delay = errors.start_delay * generator.random()
        noise = _noise(scenario.suite, errors.noise_spread, generator)
        turned = (_delayed(scenario, delay) if delay else model).turned(turn)
        variants = () if noise is None else (noise(turned),)
        flights.append(FlightSample(turned, rates, durations, delay, variants))
    return flights


class FlightSamples:
    """The flights of a scenario whose exact one is `model`, in their order.

    Each has tables of its own, a megabyte: the first `KEPT` are drawn once and stay, as searches
    ask for them in every generation; those after them are drawn whenever they are asked for.

    Attributes
    ----------
    errors : FlightErrors
        Of which they are drawn.
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
        """So many of them."""
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
    """Values, shape (n, k), of n designs in each of f flights, shape (f, n, k).

    Flights are run side by side, each in one thread: the result does not depend on how many. A
    few are in memory at once.
    """

    def one(flight: FlightSample) -> Floats:
        return values(flight.model, flight.run(designs, covariance))

    found: list[Floats] = []
    remaining = iter(flights)
    with ThreadPoolExecutor(threads or available_threads()) as pool:
        while few := list(islice(remaining, _AT_ONCE)):
            found += pool.map(one, few)
    return np.array(found)


def kept_by(values: Floats, share: float) -> Floats:
    """The least value that a share of the flights, the first axis, does not exceed.

    NaN, a covariance that lost positivity, is above every number.
    """
    ordered = np.sort(values, axis=0)
    kept: Floats = ordered[_place(len(values), share) - 1]
    return kept


def _place(count: int, share: float) -> int:
    """Of `count` ascending values the first, from 1, that a share does not exceed."""
    return max(int(np.ceil(share * count - 1e-9)), 1)


def judged(values: Floats, n_objectives: int, errors: FlightErrors) -> Floats:
    """Objectives and then constraints over flights, shape (f, n, k), as one value each, (n, k)."""
    objectives, limits = np.split(values, [n_objectives], axis=2)
    found = objectives.mean(axis=0) if errors.mean else kept_by(objectives, errors.quantile)
    return np.hstack([found, kept_by(limits, errors.kept)])


def _noise(
    suite: Suite, spread: float, generator: np.random.Generator
) -> Callable[[FilterModel], FilterModel] | None:
    """Of a model the same with noise of gyro and sensors that is off by a factor each, if any."""
    if not spread:
        return None
    parts: list[Any] = [suite.gyro, *suite.sensors]
    for part in parts:
        if not part.noise_parameters:
            raise ValueError(
                f"flight.noise_spread: {type(part).__name__} does not name its noise_parameters"
            )
    gyro, *sensors = (
        with_noise(part, float(np.exp(spread * chance)))
        for part, chance in zip(parts, generator.standard_normal(len(parts)), strict=True)
    )
    noisy = Suite(gyro, tuple(sensors), suite.world)
    return lambda model: dataclasses.replace(model, suite=noisy)


def _delayed(scenario: Scenario, delay: float) -> FilterModel:
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
