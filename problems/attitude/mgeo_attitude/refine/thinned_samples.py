"""Refinement of plans on thinned samples, which give nearly the same gradients as all samples."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter.variants import coarsen_model
from mgeo_attitude.refine.descent import descend, descend_from_best
from mgeo_attitude.refine.evaluators import FixedTimeEvaluator

#: Candidate numbers of samples to merge, the least number of merged samples in a plan, and the
#: largest rotation in a merged step [deg].
_MERGE_SIZES, _MIN_SAMPLES, _MAX_ROTATION_DEG = (20, 10, 5, 2), 100, 20.0
#: Descents within constraints take longer: largest number of initial designs, and share of the
#: iterations after which half of the designs continue, until one is left.
_MAX_CONSTRAINED_DESIGNS, _FIRST_ITERATION_SHARE = 6, 0.15
#: Number of final iterations on all samples, which are needed with constraints: thinned samples
#: represent constraints poorly.
_N_FINAL_ITERATIONS = 5


@dataclass(frozen=True)
class ThinnedSamples:
    """Plan evaluators that save computing time by merging successive measurement samples into one.

    Samples are merged as long as gradients remain accurate.

    Attributes
    ----------
    full_evaluator : FixedTimeEvaluator
        Evaluator on all samples.
    """

    full_evaluator: FixedTimeEvaluator
    _evaluators: dict[int, FixedTimeEvaluator] = field(default_factory=dict)

    def get_evaluator(self, time: float) -> FixedTimeEvaluator:
        """Return the evaluator for plans with a given end time [s]. The later the end time, the
        more measurement samples are merged into one.
        """
        model, n_merged = self.full_evaluator.model, self.count_merged_samples(time)
        if n_merged not in self._evaluators:
            self._evaluators[n_merged] = dataclasses.replace(
                self.full_evaluator, model=coarsen_model(model, n_merged)
            )
        return self._evaluators[n_merged]

    def count_merged_samples(self, time: float) -> int:
        """Return the number of measurement samples that are merged into one for plans with a given
        end time [s].
        """
        model, rate = (
            self.full_evaluator.model,
            self.full_evaluator.scenario.maneuvers.max_rate_deg_s,
        )
        most = min(time / model.step / _MIN_SAMPLES, _MAX_ROTATION_DEG / (rate * model.step))
        return next((each for each in _MERGE_SIZES if each <= most), 1)

    def find_step(self, time: float) -> int:
        """Convert a time [s] to a step of the filter model in which measurement samples are merged.

        The model is that of `get_evaluator`, which has longer steps. The result is from 1 to
        ``n_steps``.
        """
        model = self.get_evaluator(time).model
        return min(max(round(time / model.step), 1), model.n_steps)

    def evaluate_each(self, designs: Floats, times: Floats) -> tuple[Floats, Floats]:
        """Evaluate the objective and the largest constraint violation of each design at its
        time [s].

        Both arrays have the shape (n,).
        """
        value, worst = np.empty(len(designs)), np.empty(len(designs))
        n_merged = np.array([self.count_merged_samples(time) for time in times])
        for size in np.unique(n_merged):
            rows = np.flatnonzero(n_merged == size)
            steps = np.array([self.find_step(time) for time in times[rows]])
            evaluator = self.get_evaluator(times[rows[0]])
            value[rows], excess = evaluator.evaluate_at_steps(
                designs[rows], steps, allow_partial_steps=True
            )
            worst[rows] = np.maximum(excess, 0.0).max(axis=1, initial=0.0)
        return value, worst

    def select_best_per_time(self, designs: Floats, times: Floats, n_max: int) -> Ints:
        """Return the row indices of the best designs for each time, at most `n_max` per time.

        The designs are ordered by constraint violation, then by objective.

        Parameters
        ----------
        designs : array, shape (n, 4 m)
        times : array, shape (n,)
            Time of each design [s].
        n_max : int
            Largest number of designs for each time.

        Returns
        -------
        array of int
        """
        order = np.lexsort((*self.evaluate_each(designs, times), times))
        places = np.arange(len(order)) - np.searchsorted(times[order], times[order])
        return order[places < n_max]

    def refine_designs(
        self, initial_designs: Sequence[Floats], times: Floats, max_iterations: int, n_max: int
    ) -> Floats:
        """Refine several initial designs for each of n times, and return the best design per time.

        The result has the shape (n, 4 m). The descents for a time start from the initial designs
        with the smallest objective at that time. The better results continue with more iterations
        until one design is left.

        Parameters
        ----------
        initial_designs : sequence of n arrays, shape (k, 4 m)
            Initial designs for each time.
        times : array, shape (n,)
            Times [s], all with the same number of merged samples; see `count_merged_samples`.
        max_iterations : int
            Largest number of iterations of a descent.
        n_max : int
            Largest number of initial designs for each time.
        """
        evaluator = self.get_evaluator(times[0])
        is_constrained = bool(
            self.full_evaluator.motion_constraints or self.full_evaluator.covariance_constraints
        )
        n_max = min(n_max, _MAX_CONSTRAINED_DESIGNS) if is_constrained else n_max
        initial = [
            evaluator.select_best(each, self.find_step(time), n_max, allow_partial_steps=True)
            for each, time in zip(initial_designs, times, strict=True)
        ]
        if is_constrained:
            return self._descend_constrained(evaluator, initial, times, max_iterations)
        time_indices = np.repeat(np.arange(len(times)), [len(each) for each in initial])
        return descend_from_best(evaluator, np.vstack(initial), times, time_indices, max_iterations)

    def _descend_constrained(
        self,
        evaluator: FixedTimeEvaluator,
        initial: list[Floats],
        times: Floats,
        max_iterations: int,
    ) -> Floats:
        steps, share = [self.find_step(time) for time in times], _FIRST_ITERATION_SHARE
        while several := [row for row, each in enumerate(initial) if len(each) > 1]:
            sizes = [len(initial[row]) for row in several]
            designs = np.vstack([initial[row] for row in several])
            end_times = np.repeat(times[several], sizes)
            ends = descend(evaluator, designs, end_times, max(round(share * max_iterations), 1))
            for row, group in zip(several, np.split(ends, np.cumsum(sizes)[:-1]), strict=True):
                initial[row] = evaluator.select_best(
                    group, steps[row], len(group) // 2, allow_partial_steps=True
                )
            share = min(2.0 * share, 1.0)
        refined = descend(evaluator, np.vstack(initial), times, max_iterations)
        return descend(self.full_evaluator, refined, times, _N_FINAL_ITERATIONS)
