"""Plans made better on few samples, which tell the slopes as well as all do."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.thinned import thinned
from mgeo_attitude.refine.at_time import AtTime
from mgeo_attitude.refine.descent import descend

#: How many samples are taken as one, at most so that there are as many of them and that a step
#: turns by no more than so many degrees.
_EVERY, _SAMPLES, _TURN_DEG = (10, 5, 2), 100, 10.0
#: Share of the iterations after which half of the plans are left, until one is.
_SHARE = 0.35
#: Steps of a plan that is short.
SHORT = 1000
#: Iterations on all samples where there are limits, to which few do not tell the way.
_EXACT = 5


@dataclass(frozen=True)
class Roughly:
    """Values at times of `exact`, of as few samples as will do, in one thread."""

    exact: AtTime
    _known: dict[int, AtTime] = field(default_factory=dict)

    def at(self, time: float) -> AtTime:
        """That for a time [s]."""
        model, rate = self.exact.model, self.exact.scenario.maneuvers.max_rate_deg_s
        most = min(time / model.step / _SAMPLES, _TURN_DEG / (rate * model.step))
        every = next((each for each in _EVERY if each <= most), 1)
        if every not in self._known:
            self._known[every] = dataclasses.replace(
                self.exact, model=thinned(model, every), threads=1
            )
        return self._known[every]

    def descended(self, begins: Floats, time: float, iterations: int, most: int) -> Floats:
        """The best that is found from some designs, shape (k, 4 m), in so many iterations.

        At `most` so many are tried, those that are best at the time [s]; and with more iterations
        the better half of them, until it is one.
        """
        at = self.at(time)
        steps = min(max(round(time / at.model.step), 1), at.model.n_steps)
        tried, share = _least(at, begins, steps, most), _SHARE
        while len(tried) > 1:
            each = max(round(share * iterations), 1)
            tried = np.array([descend(at, design, time, each) for design in tried])
            tried, share = _least(at, tried, steps, len(tried) // 2), min(2.0 * share, 1.0)
        found = descend(at, tried[0], time, iterations)
        if self.exact.limits or self.exact.requirements:
            found = descend(self.exact, found, time, _EXACT)
        return found


def _least(at: AtTime, designs: Floats, steps: int, most: int) -> Floats:
    """Some of the designs, those of the least values, after those that keep limits best."""
    value, excess = at.values(designs, steps)
    worst = np.maximum(excess, 0.0).max(axis=1, initial=0.0)
    found: Floats = designs[np.lexsort((value, worst))[:most]]
    return found
