"""Refinement of plans on thinned samples, which give nearly the same gradients as all samples."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter.variants import coarsen_model
from mgeo_attitude.refine.at_time import AtTime
from mgeo_attitude.refine.descent import descend, descend_from_best

#: Candidate numbers of samples to merge, the least number of merged samples in a plan, and the
#: largest rotation in a merged step [deg].
_EVERY, _SAMPLES, _TURN_DEG = (20, 10, 5, 2), 100, 20.0
#: With constraints, descents take longer: largest number of initial designs, and share of the
#: iterations after which half of the designs continue, until one is left.
_WITHIN, _SHARE = 6, 0.15
#: Final iterations on all samples with constraints, which thinned samples represent poorly.
_EXACT = 5


@dataclass(frozen=True)
class ThinnedSamples:
    """Evaluation of plans on as few merged samples as accurate gradients allow.

    Attributes
    ----------
    exact : AtTime
        Evaluation on all samples.
    """

    exact: AtTime
    _known: dict[int, AtTime] = field(default_factory=dict)

    def at(self, time: float) -> AtTime:
        """Return the evaluation on thinned samples for a time [s]."""
        model, every = self.exact.model, self.every(time)
        if every not in self._known:
            self._known[every] = dataclasses.replace(self.exact, model=coarsen_model(model, every))
        return self._known[every]

    def every(self, time: float) -> int:
        """Return the number of samples to merge into one, for a time [s]."""
        model, rate = self.exact.model, self.exact.scenario.maneuvers.max_rate_deg_s
        most = min(time / model.step / _SAMPLES, _TURN_DEG / (rate * model.step))
        return next((each for each in _EVERY if each <= most), 1)

    def steps(self, time: float) -> int:
        model = self.at(time).model
        return min(max(round(time / model.step), 1), model.n_steps)

    def of_each(self, designs: Floats, times: Floats) -> tuple[Floats, Floats]:
        """Return value and largest violation of each design at its own time [s], shape (n,)."""
        value, worst = np.empty(len(designs)), np.empty(len(designs))
        every = np.array([self.every(time) for time in times])
        for size in np.unique(every):
            rows = np.flatnonzero(every == size)
            steps = np.array([self.steps(time) for time in times[rows]])
            at = self.at(times[rows[0]])
            value[rows], excess = at.values(designs[rows], steps, within_steps=True)
            worst[rows] = np.maximum(excess, 0.0).max(axis=1, initial=0.0)
        return value, worst

    def best_of_each(self, designs: Floats, times: Floats, most: int) -> Ints:
        """Return the indices of the best designs for each time [s], at most `most` per time.

        The order is that of `AtTime.best`.
        """
        order = np.lexsort((*self.of_each(designs, times), times))
        places = np.arange(len(order)) - np.searchsorted(times[order], times[order])
        return order[places < most]

    def descended(
        self, begins: Sequence[Floats], times: Floats, iterations: int, most: int
    ) -> Floats:
        """Return the best design found for each of n times, shape (n, 4 m).

        Descents start from the initial designs with the best values at the time. The better ones
        continue with more iterations until one is left.

        Parameters
        ----------
        begins : sequence of n arrays, shape (k, 4 m)
            Initial designs for each time.
        times : array, shape (n,)
            Times [s], with the same number of merged samples (see `every`).
        iterations : int
            Largest number of iterations of a descent.
        most : int
            Largest number of initial designs for each time.
        """
        at = self.at(times[0])
        limited = bool(self.exact.limits or self.exact.requirements)
        most = min(most, _WITHIN) if limited else most
        initial = [
            at.best(each, self.steps(time), most, within_steps=True)
            for each, time in zip(begins, times, strict=True)
        ]
        if limited:
            return self._within_limits(at, initial, times, iterations)
        which = np.repeat(np.arange(len(times)), [len(each) for each in initial])
        return descend_from_best(at, np.vstack(initial), times, which, iterations)

    def _within_limits(
        self, at: AtTime, initial: list[Floats], times: Floats, iterations: int
    ) -> Floats:
        steps, share = [self.steps(time) for time in times], _SHARE
        while several := [row for row, each in enumerate(initial) if len(each) > 1]:
            sizes = [len(initial[row]) for row in several]
            designs = np.vstack([initial[row] for row in several])
            until = np.repeat(times[several], sizes)
            ends = descend(at, designs, until, max(round(share * iterations), 1))
            for row, own in zip(several, np.split(ends, np.cumsum(sizes)[:-1]), strict=True):
                initial[row] = at.best(own, steps[row], len(own) // 2, within_steps=True)
            share = min(2.0 * share, 1.0)
        refined = descend(at, np.vstack(initial), times, iterations)
        return descend(self.exact, refined, times, _EXACT)
