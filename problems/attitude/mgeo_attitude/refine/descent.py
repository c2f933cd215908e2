"""Sequential quadratic programming on what a plan is worth at a time."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.refine.at_time import AtTime
from mgeo_attitude.refine.partial_steps import with_partial_steps
from mgeo_attitude.refine.quasi_newton import minimized

#: Change of a rate, of the greatest, by which slopes are taken; of a duration, of a step.
_SMALL, _PART = 1e-5, 1e-2
#: By how much of their bounds limits are kept, so that rounding does not break them.
_MARGIN = 1e-6
#: A change of the logarithm of the value that is not worth another iteration.
_ENOUGH = 1e-5
#: A share of the time that is none.
_NOTHING = 1e-12
#: What stands for an infinite value.
_WORST = 1e3


@dataclass
class Descent:
    """One plan's values and slopes at a time [s], as functions of variables between -1 and 1.

    Variables are the rates over the greatest, and the shares that durations have of the time; they
    need not sum up to one.
    """

    at: AtTime
    time: float
    count: int
    _known: dict[bytes, tuple[Floats, Floats]] = field(default_factory=dict)

    @property
    def steps(self) -> int:
        """Of the model, which may be a coarse one."""
        return min(max(round(self.time / self.at.model.step), 1), self.at.model.n_steps)

    @property
    def bounds(self) -> Floats:
        """Least and greatest, shape (4 m, 2)."""
        return np.array([(-1.0, 1.0)] * (3 * self.count) + [(0.0, 1.0)] * self.count)

    def variables(self, design: Floats) -> Floats:
        """Of a design, shape (4 m,)."""
        maneuvers = design.reshape(-1, VARIABLES_PER_MANEUVER)
        rates = maneuvers[:, :3] / self.at.scenario.maneuvers.max_rate_deg_s
        found = np.concatenate([rates.ravel(), maneuvers[:, 3] / self.time])
        within: Floats = np.clip(found, *self.bounds.T)
        return within

    def designs(self, variables: Floats) -> Floats:
        """Of rows of variables, shape (n, 4 m), which fill the time where they can."""
        z = np.clip(np.atleast_2d(variables), *self.bounds.T)
        limits, n = self.at.scenario.maneuvers, len(z)
        rates = limits.max_rate_deg_s * z[:, : 3 * self.count].reshape(n, -1, 3)
        shares = z[:, 3 * self.count :] + _NOTHING
        durations = self.time * shares / shares.sum(axis=1, keepdims=True)
        # what would be longer than a maneuver may be goes to those with room, by their room
        room = np.maximum(limits.max_duration - durations, 0.0)
        over = np.maximum(durations - limits.max_duration, 0.0).sum(axis=1, keepdims=True)
        given = np.minimum(over / np.maximum(room.sum(axis=1, keepdims=True), _NOTHING), 1.0)
        durations = np.minimum(durations, limits.max_duration) + given * room
        return np.concatenate([rates, durations[:, :, None]], axis=2).reshape(n, -1)

    def value(self, z: Floats) -> tuple[float, Floats]:
        """The value alone and its slopes, shape (4 m,)."""
        found, slopes = self.known(z)
        return float(found[0]), slopes[0]

    def known(self, z: Floats) -> tuple[Floats, Floats]:
        """Value and margins, shape (1 + k,), and their slopes, shape (1 + k, 4 m)."""
        key = z.tobytes()
        if key not in self._known:
            self._known = {key: self._taken(z)}
        return self._known[key]

    def _taken(self, z: Floats) -> tuple[Floats, Floats]:
        """All of them by one batch of the kernel."""
        model = self.at.model
        smooth = model.slew_limits is None  # or else ramps begin on steps
        steps = np.full(len(z), _SMALL)
        steps[3 * self.count :] = (_PART if smooth else 1.0) * model.step / self.time
        steps = np.where(z + steps > self.bounds[:, 1], -steps, steps)
        designs = self.designs(np.vstack([z, z + np.diag(steps)]))
        if smooth:
            designs = with_partial_steps(designs, model.step)
        value, excess = self.at.values(designs, self.steps, required=True)
        found = np.column_stack([np.minimum(value, _WORST), -_MARGIN - np.minimum(excess, _WORST)])
        return found[0], (found[1:] - found[0]).T / steps


def descend(at: AtTime, design: Floats, time: float, iterations: int) -> Floats:
    """A design that is worth more at a time [s], within all limits, as far as can be found.

    Slopes are differences, one batch of the kernel for each point. With limits steps are those of
    SLSQP (D. Kraft, A software package for sequential quadratic programming, DFVLR-FB 88-28, 1988),
    or else of `quasi_newton`.

    Parameters
    ----------
    design : array, shape (4 m,)
        Whose maneuvers are over by then.
    """
    problem = Descent(at, time, design.size // VARIABLES_PER_MANEUVER)
    z = problem.variables(design)
    if len(problem.known(z)[0]) > 1:
        z = _within_limits(problem, z, iterations)
    else:
        z = minimized(problem.value, z, problem.bounds, iterations, _ENOUGH)
    if not np.isfinite(z).all():
        return design
    best: Floats = problem.designs(z)[0]
    return best


def _within_limits(problem: Descent, z: Floats, iterations: int) -> Floats:
    from scipy.optimize import minimize  # which takes long to import

    margins = {
        "type": "ineq",
        "fun": lambda z: problem.known(z)[0][1:],
        "jac": lambda z: problem.known(z)[1][1:],
    }
    with warnings.catch_warnings():
        # its line search may leave the bounds by rounding, and says so
        warnings.filterwarnings("ignore", "Values in x were outside bounds", RuntimeWarning)
        found: Floats = minimize(
            problem.value,
            z,
            jac=True,
            bounds=problem.bounds,
            constraints=[margins],
            method="SLSQP",
            options={"maxiter": iterations, "ftol": _ENOUGH},
        ).x
    return found
