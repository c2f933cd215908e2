"""Models of a satellite that begins at one of several times, all of them in one table.

What surrounds the satellite is computed once, from the first start to the end of the last run. A
run that begins later reads the same rows, from its own first one on.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.environment.directions import Place
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.momentum import MomentumBudget
from mgeo_attitude.maneuvers.drives import CoilDrive
from mgeo_attitude.scenario.actuators import slew_limits

if TYPE_CHECKING:
    from mgeo_attitude.filter.evaluator import Evaluation
    from mgeo_attitude.scenario.scenario import Scenario

#: Models that stay in memory: they are views of the one table.
_KEPT = 256


Kept = TypeVar("Kept")


def kept(known: dict[int, Kept], key: int, make: Callable[[int], Kept], most: int) -> Kept:
    """What is `known` by a key, or made; of more than `most` the oldest go. Threads share it."""
    found = known.get(key)
    if found is None:
        found = make(key)
        for oldest in list(known)[: max(len(known) + 1 - most, 0)]:
            known.pop(oldest, None)
        known[key] = found
    return found


@dataclass(frozen=True)
class StartTimes:
    """Models that begin at `times` [s] after a scenario's epoch, shape (n,), ascending.

    Attributes
    ----------
    whole : FilterModel
        Of all samples, from the epoch to the end of the last run.
    environment : Environment
        Of the same samples.
    """

    scenario: Scenario
    times: Floats
    environment: Environment
    whole: FilterModel
    _known: dict[int, FilterModel] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def of(cls, scenario: Scenario, times: Floats) -> StartTimes:
        """Those of a scenario that may begin at `times`.

        Raises
        ------
        ValueError
            As `FilterModel.from_scenario`.
        """
        delay = 0.0 if scenario.flight is None else scenario.flight.start_delay
        count = round((times[-1] + scenario.duration + delay) / scenario.step)
        span = dataclasses.replace(
            scenario,
            maneuvers=dataclasses.replace(
                scenario.maneuvers, latest_start=None, start_interval=None
            ),
            duration=count * scenario.step,
            flight=None,
            windows=(),
        )
        environment = Environment.from_scenario(span)
        return cls(scenario, times, environment, FilterModel.from_scenario(span, environment))

    @property
    def n_steps(self) -> int:
        """Of a run."""
        return self.scenario.n_steps

    @property
    def sampling(self) -> int:
        """Steps after which all sensors' samples come together again."""
        intervals = [sensor.sample_interval for sensor in self.scenario.sensors]
        steps = [round(each / self.scenario.step) for each in intervals if each is not None]
        return int(np.lcm.reduce([1, *steps]))

    def nearest(self, starts: Floats) -> Ints:
        """Numbers of the start times nearest to `starts` [s], of any shape."""
        after = np.searchsorted(self.times, starts).clip(1, max(len(self.times) - 1, 1))
        before = after - 1
        after = after.clip(max=len(self.times) - 1)
        numbers: Ints = np.where(
            starts - self.times[before] <= self.times[after] - starts, before, after
        )
        return numbers

    def row(self, number: int, delay: int = 0) -> int:
        """First row of a run that begins at a start time, or so many steps later."""
        return round(float(self.times[number]) / self.scenario.step) + delay

    def at(self, number: int, delay: int = 0) -> FilterModel:
        """The model that begins at a start time, or so many steps later."""
        return kept(self._known, self.row(number, delay), self._made, _KEPT)

    def surroundings(self, number: int) -> Environment:
        """The `environment` of its run, whose times count from that start."""
        first = self.row(number)
        part, found = slice(first, first + self.n_steps + 1), self.environment
        begins = self.scenario.starting(float(self.times[number]))
        names = ("position", "velocity", "sun", "field", "sunlit")
        tables = {name: getattr(found, name)[part] for name in names}
        epoch = begins.epoch if found.epoch else None
        return Environment(begins.times, **tables, origin=begins, epoch=epoch)

    def evaluate(
        self,
        designs: Floats,
        threads: int | None = None,
        delay: int = 0,
        vary: Callable[[FilterModel], FilterModel] | None = None,
        **asked: Any,
    ) -> Evaluation:
        """`evaluator.evaluate` of designs with their start, shape (n, 4 m + 1).

        Parameters
        ----------
        delay : int
            Steps by which all begin later.
        vary : function, optional
            A variant of each model, such as one of other noise or rule.
        """
        from mgeo_attitude.filter.evaluator import evaluate  # compiles
        from mgeo_attitude.filter.jobs import Begins

        maneuvers, numbers = self.split(designs)
        every, which = np.unique(numbers, return_inverse=True)
        models = [self.at(number, delay) for number in every.tolist() or [0]]
        models = [vary(model) for model in models] if vary else models
        rows = np.array([self.row(number, delay) for number in every.tolist() or [0]])
        begins = Begins(self.whole.table, self.whole.gated, rows)
        ran = evaluate(
            models[0],
            maneuvers,
            threads,
            variants=models,
            which=which.astype(np.int64),
            begins=begins,
            **asked,
        )
        return dataclasses.replace(ran, start=self.times[numbers])

    def split(self, designs: Floats) -> tuple[Floats, Ints]:
        """Maneuvers, shape (n, 4 m), and the number of the start time nearest to each design's."""
        table = np.atleast_2d(designs)
        return np.ascontiguousarray(table[:, :-1]), self.nearest(table[:, -1])

    def turned(self, turn: Floats) -> StartTimes:
        """The same from other attitudes, see `FilterModel.turned`."""
        return dataclasses.replace(self, whole=self.whole.turned(turn), _known={})

    def _made(self, first: int) -> FilterModel:
        """Views of the rows of a run, and what its first one says."""
        whole, scenario = self.whole, self.scenario
        rows = slice(first, first + self.n_steps + 1)
        # the satellite itself is not turned: how it begins does not follow from turned tables
        start = Place.row(self.environment, first)
        attitude, rate = scenario.initial_attitude(start), scenario.initial_rate(start)
        limits, budget = whole.slew_limits, whole.budget
        if isinstance(limits, CoilDrive):
            limits = dataclasses.replace(
                limits,
                field=limits.field[rows],
                initial_attitude=np.ascontiguousarray(attitude),
                initial_rate=rate,
            )
        elif limits is not None:
            limits = slew_limits(scenario.maneuvers, scenario.wheels, rate)
        if budget is not None:
            made = MomentumBudget.of(scenario, self.environment, attitude, rate)
            assert made is not None  # as the whole has one
            budget = dataclasses.replace(
                made, position=budget.position[rows], field=budget.field[rows]
            )
        return whole.at_samples(
            rows,
            initial_attitude=attitude,
            initial_rate=rate,
            slew_limits=limits,
            budget=budget,
        )
