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
#: Plans of those to begin from that are tried, of plans of fewer than `SHORT` steps more, with what
#: share of the iterations.
_TRIED, _TRIED_SHORT, SHORT, _SHARE = 2, 4, 1000, 0.25
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

    def descended(self, begins: Floats, time: float, iterations: int) -> Floats:
        """The best that is found from some designs, shape (k, 4 m), in so many iterations.

        Those that are best at the time [s] are all tried, and then the best of them alone.
        """
        at = self.at(time)
        steps = min(max(round(time / at.model.step), 1), at.model.n_steps)
        value, excess = at.values(begins, steps)
        worst = np.maximum(excess, 0.0).max(axis=1, initial=0.0)
        short = time <= SHORT * self.exact.model.step
        order = np.lexsort((value, worst))[: _TRIED_SHORT if short else _TRIED]
        first = max(round(_SHARE * iterations), 1)
        tried = np.array([descend(at, begins[row], time, first) for row in order])
        found = descend(at, tried[at.best(tried, steps)], time, iterations - first)
        if self.exact.limits or self.exact.requirements:
            found = descend(self.exact, found, time, _EXACT)
        return found
