"""Sequential quadratic programming on what a plan is worth at a time."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import minimize

from mgeo_attitude._typing import Floats
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.refine.at_time import AtTime

#: Change of a rate, of the greatest, by which slopes are taken; durations change by a step.
_SMALL = 1e-5
#: By how much of their bounds limits are kept, so that rounding does not break them.
_MARGIN = 1e-6
#: A change of the logarithm of the value that is not worth another iteration.
_ENOUGH = 1e-5
#: What stands for an infinite value.
_WORST = 1e3


@dataclass
class Descent:
    """One plan's values and slopes at a time, as functions of variables between -1 and 1.

    Variables are the rates over the greatest and the durations of all but the last maneuver over
    the time; the last one fills what is left of it.
    """

    at: AtTime
    steps: int
    count: int
    _known: dict[bytes, tuple[Floats, Floats]] = field(default_factory=dict)

    @property
    def time(self) -> float:
        return self.steps * self.at.model.step

    @property
    def bounds(self) -> Floats:
        """Least and greatest, shape (4 m - 1, 2)."""
        longest = min(self.at.scenario.maneuvers.max_duration / self.time, 1.0)
        rates, durations = [(-1.0, 1.0)] * (3 * self.count), [(0.0, longest)] * (self.count - 1)
        return np.array(rates + durations)

    def variables(self, design: Floats) -> Floats:
        """Of a design, shape (4 m,)."""
        maneuvers = design.reshape(-1, VARIABLES_PER_MANEUVER)
        rates = maneuvers[:, :3] / self.at.scenario.maneuvers.max_rate_deg_s
        found = np.concatenate([rates.ravel(), maneuvers[:-1, 3] / self.time])
        within: Floats = np.clip(found, *self.bounds.T)
        return within

    def designs(self, variables: Floats) -> Floats:
        """Of rows of variables, shape (n, 4 m)."""
        z = np.clip(np.atleast_2d(variables), *self.bounds.T)
        limits, n = self.at.scenario.maneuvers, len(z)
        rates = limits.max_rate_deg_s * z[:, : 3 * self.count].reshape(n, -1, 3)
        durations = self.time * z[:, 3 * self.count :]
        left = np.clip(self.time - durations.sum(axis=1), 0.0, limits.max_duration)
        durations = np.column_stack([durations, left])
        return np.concatenate([rates, durations[:, :, None]], axis=2).reshape(n, -1)

    def known(self, z: Floats) -> tuple[Floats, Floats]:
        """Value and margins, shape (1 + k,), and their slopes, shape (1 + k, 4 m - 1)."""
        key = z.tobytes()
        if key not in self._known:
            self._known = {key: self._taken(z)}
        return self._known[key]

    def _taken(self, z: Floats) -> tuple[Floats, Floats]:
        """All of them by one batch of the kernel."""
        steps = np.full(len(z), _SMALL)
        steps[3 * self.count :] = self.at.model.step / self.time
        steps = np.where(z + steps > self.bounds[:, 1], -steps, steps)
        value, excess = self.at.values(
            self.designs(np.vstack([z, z + np.diag(steps)])), self.steps, required=True
        )
        found = np.column_stack([np.minimum(value, _WORST), -_MARGIN - np.minimum(excess, _WORST)])
        return found[0], (found[1:] - found[0]).T / steps


def descend(at: AtTime, design: Floats, steps: int, iterations: int) -> Floats:
    """A design that is worth more after so many steps, within all limits, as far as can be found.

    Slopes are differences, one batch of the kernel for each point; steps are those of SLSQP (D.
    Kraft, A software package for sequential quadratic programming, DFVLR-FB 88-28, 1988).

    Parameters
    ----------
    design : array, shape (4 m,)
        Whose maneuvers are over by then.
    """
    problem = Descent(at, steps, design.size // VARIABLES_PER_MANEUVER)
    z, first = problem.variables(design), 3 * problem.count
    n_limits = len(problem.known(z)[0]) - 1
    constraints = []
    if n_limits:
        constraints.append(
            {
                "type": "ineq",
                "fun": lambda z: problem.known(z)[0][1:],
                "jac": lambda z: problem.known(z)[1][1:],
            }
        )
    if problem.count > 1:
        slope = np.zeros(len(z))
        slope[first:] = -1.0
        constraints.append(
            {"type": "ineq", "fun": lambda z: 1.0 - z[first:].sum(), "jac": lambda z: slope}
        )
    with warnings.catch_warnings():
        # its line search may leave the bounds by rounding, and says so
        warnings.filterwarnings("ignore", "Values in x were outside bounds", RuntimeWarning)
        found = minimize(
            lambda z: problem.known(z)[0][0],
            z,
            jac=lambda z: problem.known(z)[1][0],
            bounds=problem.bounds,
            constraints=constraints,
            method="SLSQP",
            options={"maxiter": iterations, "ftol": _ENOUGH},
        )
    if not np.isfinite(found.x).all():
        return design
    best: Floats = problem.designs(found.x)[0]
    return best
