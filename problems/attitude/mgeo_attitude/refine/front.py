"""Rows that better plans take: those of a front, and times between them at which it has none."""

from __future__ import annotations

import numpy as np

from mgeo.evaluation.dominance import front_rows
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.refine.at_time import Judge

#: Share of the time of a row below which none takes its place, but for the last.
_NEARLY = 0.98
#: How much closer than others rows are at most, where much is learned from one to the next.
_CLOSER = 3.0


class Front:
    """Plans, the times until which they may last, and what is known then.

    Parameters
    ----------
    judge : function
        Gives time and value of designs, shape (n, 2), and violations.
    X : array, shape (n, n_var)
        Plans that are there.
    ratio : float
        Between times of rows: where the plans leave more there is room for others.

    Attributes
    ----------
    times : array, shape (n + r,)
        Of the rows [s], those of the plans first.
    """

    def __init__(self, judge: Judge, X: Floats, ratio: float = np.inf) -> None:
        self._judge = judge
        F, violation = judge(X)
        self._given = len(X)
        self._added: list[int] = []
        room, best = _room(F, violation, ratio)
        self.X = np.vstack([X, X[best]])
        self._F = np.vstack([F, np.column_stack([room, F[best, 1]])])
        self._violation = np.append(violation, violation[best])
        self.times = self._F[:, 0].copy()

    @property
    def rows(self) -> Ints:
        """That hold plans: those that there were, and others in the order in which they came."""
        return np.array([*range(self._given), *self._added], dtype=np.int64)

    @property
    def plans(self) -> Floats:
        """Of these rows, shape (n + a, n_var)."""
        return self.X[self.rows]

    def take(self, designs: Floats) -> None:
        """Let designs take the place of rows that end no sooner and know less, within limits.

        None that ends much before the time that a row had at first, at which more can be known.
        """
        self._take(designs, np.arange(len(self.X)), _NEARLY)

    def settle(self) -> None:
        """Let plans take the place of all that end later and know less."""
        self._take(self.plans, self.rows, 0.0)

    def _take(self, designs: Floats, rows: Ints, share: float) -> None:
        if not len(designs):
            return
        F, violation = self._judge(designs)
        sound = np.flatnonzero(np.isfinite(F).all(axis=1) & (violation <= 0.0))
        order = sound[front_rows(F[sound])]
        place = np.searchsorted(F[order, 0], self._F[rows, 0], side="right") - 1
        rows, place = rows[place >= 0], place[place >= 0]
        best = order[place]
        better = (F[best, 1] < self._F[rows, 1]) & (F[best, 0] >= share * self.times[rows])
        better |= self._violation[rows] > 0.0
        rows, best = rows[better], best[better]
        self.X[rows], self._F[rows], self._violation[rows] = designs[best], F[best], 0.0
        known = set(self._added)
        self._added += [row for row in rows.tolist() if row >= self._given and row not in known]


def _room(F: Floats, violation: Floats, ratio: float) -> tuple[Floats, Ints]:
    """Times between those of sound plans, at such a ratio, and the best plan until each.

    Closer where values fall by more than this ratio.
    """
    sound = np.flatnonzero(np.isfinite(F).all(axis=1) & (violation <= 0.0) & (F[:, 0] > 0.0))
    order = sound[front_rows(F[sound])]
    if len(order) < 2 or not np.isfinite(ratio):
        return np.empty(0), np.empty(0, dtype=np.int64)
    logs, values = np.log(F[order, 0]), F[order, 1]
    gaps = np.diff(logs)
    falls = -np.diff(np.log(values)) if (values > 0.0).all() else gaps
    steps = np.clip(falls, gaps, _CLOSER * gaps)
    times, best = [], []
    for k, (gap, step) in enumerate(zip(gaps, steps, strict=True)):
        number = int(step / np.log(ratio))
        times += (logs[k] + gap * np.arange(1, number + 1) / (number + 1)).tolist()
        best += [order[k]] * number
    return np.exp(np.array(times)), np.array(best, dtype=np.int64)
