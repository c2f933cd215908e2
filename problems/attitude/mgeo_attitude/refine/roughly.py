"""Plans made better on few samples, which tell the slopes as well as all do."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter.variants import thinned
from mgeo_attitude.refine.at_time import AtTime
from mgeo_attitude.refine.descent import descend, descend_from_best

#: How many samples are taken as one, at most so that there are as many of them and that a step
#: turns by no more than so many degrees.
_EVERY, _SAMPLES, _TURN_DEG = (20, 10, 5, 2), 100, 20.0
#: Of plans within limits, whose descents take longer, how many are tried at most, and after which
#: share of the iterations half of them are left, until one is.
_WITHIN, _SHARE = 6, 0.15
#: Iterations on all samples where there are limits, to which few do not tell the way.
_EXACT = 5


@dataclass(frozen=True)
class Roughly:
    """Values at times of `exact`, of as few samples as will do."""

    exact: AtTime
    _known: dict[int, AtTime] = field(default_factory=dict)

    def at(self, time: float) -> AtTime:
        """That for a time [s]."""
        model, every = self.exact.model, self.every(time)
        if every not in self._known:
            self._known[every] = dataclasses.replace(self.exact, model=thinned(model, every))
        return self._known[every]

    def every(self, time: float) -> int:
        """Of how many samples one is taken for a time [s]."""
        model, rate = self.exact.model, self.exact.scenario.maneuvers.max_rate_deg_s
        most = min(time / model.step / _SAMPLES, _TURN_DEG / (rate * model.step))
        return next((each for each in _EVERY if each <= most), 1)

    def steps(self, time: float) -> int:
        """Of the few samples until a time [s]."""
        model = self.at(time).model
        return min(max(round(time / model.step), 1), model.n_steps)

    def of_each(self, designs: Floats, times: Floats) -> tuple[Floats, Floats]:
        """Values of designs, each at its own time [s], shape (n,), and greatest excesses then."""
        value, worst = np.empty(len(designs)), np.empty(len(designs))
        distinct, which = np.unique(times, return_inverse=True)
        samplings = [self.at(time) for time in distinct]
        steps = np.array([self.steps(time) for time in distinct], dtype=np.int64)[which]
        for at in self._known.values():
            rows = np.flatnonzero(np.array([each is at for each in samplings], dtype=bool)[which])
            if len(rows):
                value[rows], excess = at.values(designs[rows], steps[rows], within_steps=True)
                worst[rows] = np.maximum(excess, 0.0).max(axis=1, initial=0.0)
        return value, worst

    def best_of_each(self, designs: Floats, times: Floats, most: int) -> Ints:
        """Rows of designs, for each of their times [s], shape (n,), the few that teach most.

        As `AtTime.best`, each at its own time.
        """
        order = np.lexsort((*self.of_each(designs, times), times))
        places = np.arange(len(order)) - np.searchsorted(times[order], times[order])
        found: Ints = order[places < most]
        return found

    def descended(
        self, begins: Sequence[Floats], times: Floats, iterations: int, most: int
    ) -> Floats:
        """The best found from some designs, shape (k, 4 m), for each of n times, shape (n, 4 m).

        For each time [s] at `most` so many are tried, those that are best then; and with more
        iterations the better half of them, until it is one.
        """
        found = np.empty((len(times), begins[0].shape[1]))
        samplings = [self.at(time) for time in times]
        limited = bool(self.exact.limits or self.exact.requirements)
        most = min(most, _WITHIN) if limited else most
        for at in self._known.values():
            rows = [row for row, each in enumerate(samplings) if each is at]
            if not rows:
                continue
            tried = [
                at.best(begins[row], self.steps(times[row]), most, within_steps=True)
                for row in rows
            ]
            if limited:
                found[rows] = self._within_limits(at, tried, times[rows], iterations)
            else:
                which = np.repeat(np.arange(len(rows)), [len(each) for each in tried])
                designs = np.vstack(tried)
                found[rows] = descend_from_best(at, designs, times[rows], which, iterations)
        return found

    def _within_limits(
        self, at: AtTime, tried: list[Floats], times: Floats, iterations: int
    ) -> Floats:
        steps, share = [self.steps(time) for time in times], _SHARE
        while several := [row for row, each in enumerate(tried) if len(each) > 1]:
            sizes = [len(tried[row]) for row in several]
            designs = np.vstack([tried[row] for row in several])
            until = np.repeat(times[several], sizes)
            ends = descend(at, designs, until, max(round(share * iterations), 1))
            for row, own in zip(several, np.split(ends, np.cumsum(sizes)[:-1]), strict=True):
                tried[row] = at.best(own, steps[row], len(own) // 2, within_steps=True)
            share = min(2.0 * share, 1.0)
        found = descend(at, np.vstack(tried), times, iterations)
        return descend(self.exact, found, times, _EXACT)
