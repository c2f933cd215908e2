"""What a generated kernel keeps of each candidate, and where: the slots of its workspace."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import accumulate
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mgeo_attitude.environment.directions import DIRECTIONS
from mgeo_attitude.filter.suite import Suite
from mgeo_attitude.filter.symbols import slots_of

if TYPE_CHECKING:
    from mgeo_attitude.scenario import PathLimit


class Watch(NamedTuple):
    """A path limit as the kernel watches it.

    Attributes
    ----------
    direction : str
    inside : bool
        Whether the direction must stay in the cone.
    disc : bool
        Whether its angle counts from a limb.
    margin : bool
        Whether there is one for the unknown attitude.
    plain : bool
        Whether the cosine of the angle tells all: its greatest value is then kept. Of all others
        the greatest excess is kept [rad], see `path_limits.excess`.
    """

    direction: str
    inside: bool
    disc: bool
    margin: bool
    plain: bool

    @classmethod
    def of(cls, limit: PathLimit) -> Watch:
        cone, margin = limit.cone(), limit.attitude_sigmas > 0.0
        # in the dark the cosine is zero, as if at 90 deg
        plain = not (cone.inside or cone.disc or margin or limit.half_angle_deg >= 90.0)
        return cls(cone.direction, cone.inside, cone.disc, margin, plain)


@dataclass(frozen=True)
class Monitors:
    """What is watched of every design along its run, beside the filter itself.

    Attributes
    ----------
    limits : tuple of Watch
        Path limits.
    states : tuple of int
        States with a required 1-sigma. If there are any, one value follows: at how many samples up
        to now, without a break, all requirements have been met.
    """

    limits: tuple[Watch, ...] = ()
    states: tuple[int, ...] = ()

    @property
    def total(self) -> int:
        return len(self.limits) + bool(self.states)


NO_MONITORS = Monitors()


class Layout(NamedTuple):
    """First slot of each kind of value, in this order.

    The covariance is before all others, from slot 0 on. It, the `attitude` and the `monitors` are a
    candidate's state; `rotation`, `F` and `Q` are those of one step of its maneuver. `trace` and
    `pivot` are what `step` and `check` find. Loops keep in `scratch` what they hand on. `given` are
    what the orbit gives at the step; the `constants` are the same for all candidates. A maneuver's
    `rate`, squared [rad²/s²], is there only if a sensor has a greatest one.
    """

    attitude: int
    monitors: int
    rotation: int
    F: int
    Q: int
    rate: int
    trace: int
    pivot: int
    scratch: int
    given: int
    constants: int


@cache
def layout(suite: Suite, gated: tuple[bool, ...], monitors: Monitors = NO_MONITORS) -> Layout:
    """Workspace of a suite; `gated` tells which sensors are not available at every sample.

    Given is a row of `FilterModel.table`: the reference of each sensor, and their gradients; each
    of `directions_of`; of each that is a disc the radius with its cosine and sine; whether each
    gated sensor is available.
    """
    n, m = suite.n_states, suite.n_kinematic
    names = directions_of(suite, monitors)
    given = 3 * (suite.n_vectors + len(names) + len(discs(names))) + sum(gated)
    n_transition = len(transition_pattern(suite))
    rated = any(sensor.max_rate() < np.inf for sensor in suite.sensors)
    kept = [slots_of(n), 9, monitors.total]
    return Layout(
        *accumulate([*kept, 9, n_transition, slots_of(m), int(rated), 1, 1, slots_of(n), given])
    )


def directions_of(suite: Suite, monitors: Monitors = NO_MONITORS) -> tuple[str, ...]:
    """Directions that path limits, and then sensors, look at; each once."""
    names = [watch.direction for watch in monitors.limits]
    names += [view.direction for sensor in suite.sensors for view in sensor.views()]
    return tuple(dict.fromkeys(name for name in names if name))


def discs(names: tuple[str, ...]) -> tuple[str, ...]:
    """Those that are discs."""
    return tuple(name for name in names if DIRECTIONS[name].radius is not None)


@cache
def transition_pattern(suite: Suite) -> tuple[tuple[int, int], ...]:
    """Entries of exp(A dt), for any rate, in the rows of the kinematic states that change.

    They are the transitive closure of A's pattern. A state without dynamics and without process
    noise is constant: its row stays the identity's and is left out.
    """
    k = suite.n_kinematic
    generic = np.zeros((k, k), dtype=bool)
    for omega in np.vstack([np.zeros(3), np.eye(3)]):
        generic |= suite.dynamics_matrix(omega)[:k, :k] != 0.0
    closure = generic | np.eye(k, dtype=bool)
    for _ in range(k):
        closure = closure @ closure
    rows = generic.any(axis=1) | (suite.diffusion()[:k] > 0.0)
    return tuple((int(i), int(j)) for i, j in np.argwhere(closure) if rows[i])
