"""What a generated kernel is made for, and what it keeps of each candidate where: its slots."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from mgeo_attitude.environment.directions import DIRECTIONS
from mgeo_attitude.filter.symbols import slots_of
from mgeo_attitude.scenario.limits import PathLimit
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.sensors.world import World


class Watch(NamedTuple):
    """A path limit as the kernel watches it: the greatest `path_limits.excess` so far [rad].

    Attributes
    ----------
    direction : str
    inside : bool
        Whether the direction must stay in the cone.
    disc : bool
        Whether its angle counts from a limb.
    margin : bool
        Whether there is one for the unknown attitude.
    """

    direction: str
    inside: bool
    disc: bool
    margin: bool

    @classmethod
    def of(cls, limit: PathLimit) -> Watch:
        cone = limit.cone()
        return cls(cone.direction, cone.inside, cone.disc, limit.attitude_sigmas > 0.0)


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
    `rate`, squared [rad²/s²], is there only if a sensor has a greatest one; its `turn` only if
    there are path limits: the unit axis of what a step turns by, the angle, its sine and cosine.
    The `omega` itself [rad/s] is there only if a sensor has a delay.
    """

    attitude: int
    monitors: int
    rotation: int
    F: int
    Q: int
    turn: int
    rate: int
    omega: int
    trace: int
    pivot: int
    scratch: int
    given: int
    constants: int


@cache
def layout(suite: Suite, gated: tuple[bool, ...], monitors: Monitors = NO_MONITORS) -> Layout:
    """Workspace of a suite; `gated` tells which sensors are not available at every sample.

    Given is a row of `FilterModel.table`, see `given_columns`.
    """
    n, m = suite.n_states, suite.n_kinematic
    given = given_columns(suite, gated, monitors)["end"]
    n_transition = len(transition_pattern(suite))
    rated = any(sensor.max_rate() < np.inf for sensor in suite.sensors)
    kept, maneuver = [slots_of(n), 9, monitors.total], [9, n_transition, slots_of(m)]
    late = any(sensor.delay() for sensor in suite.sensors)
    optional = [6 if monitors.limits else 0, int(rated), 3 if late else 0]
    return Layout(*accumulate([*kept, *maneuver, *optional, 1, 1, slots_of(n), given]))


def given_columns(
    suite: Suite, gated: tuple[bool, ...], monitors: Monitors = NO_MONITORS
) -> dict[str, int]:
    """First column in `FilterModel.table` of each part of it, and the ``end``.

    The ``references`` of sensors, and their gradients. ``off NAME`` of each direction that path
    limits look at: at the end of the step to the sample, by how much it has moved, and whether it
    appears in the step; of a disc radius and its change, too. ``view NAME`` of each that sensors
    look at, at the sample, and of a disc cosine and sine of the radius. Whether each gated sensor
    is ``available``; before that what ``influences`` are times.
    """
    widths = {"references": 3 * suite.n_vectors}
    for name in watched_directions(monitors):
        widths[f"off {name}"] = 9 if is_disc(name) else 7
    for name in viewed_directions(suite):
        widths[f"view {name}"] = 5 if is_disc(name) else 3
    widths |= {"influences": len(suite.influence_keys), "available": sum(gated), "end": 0}
    return dict(zip(widths, accumulate([0, *widths.values()]), strict=False))


def directions_of(suite: Suite, monitors: Monitors = NO_MONITORS) -> tuple[str, ...]:
    """Directions that path limits, and then sensors, look at; each once."""
    return tuple(dict.fromkeys([*watched_directions(monitors), *viewed_directions(suite)]))


def watched_directions(monitors: Monitors) -> tuple[str, ...]:
    """Those that path limits look at."""
    return tuple(dict.fromkeys(watch.direction for watch in monitors.limits))


def viewed_directions(suite: Suite) -> tuple[str, ...]:
    """Those that sensors look at."""
    names = (view.direction for sensor in suite.sensors for view in sensor.views())
    return tuple(dict.fromkeys(name for name in names if name))


def is_disc(name: str) -> bool:
    """Whether a direction is that of a disc."""
    return DIRECTIONS[name].radius is not None


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


class Traits(NamedTuple):
    """What a compiled kernel depends on: equal in all models that one kernel serves.

    Attributes
    ----------
    states : tuple of str
        Blocks of the suite.
    considered_states : tuple of int
    directions_in_view : tuple of (str, bool)
        Directions of path limits and of sensors' views, and whether they have to be inside.
    number_of_constants : int
        Number of constants of a filter step that instruments and path limits have.
    measurements : tuple of bytes
        H of each sensor, see `slopes`.
    """

    states: tuple[str, ...]
    considered_states: tuple[int, ...]
    directions_in_view: tuple[tuple[str, bool], ...]
    number_of_constants: int
    measurements: tuple[bytes, ...]


@lru_cache(maxsize=1000)
def slopes(sensor: Sensor, world: World) -> bytes:
    """H of a sensor, somewhere: its numbers are part of the kernel."""
    suite, somewhere = Suite(Gyro(), (sensor,), world), np.array([0.36, -0.48, 0.8])
    gradient = [np.roll(somewhere, k + 1) for k in range(suite.n_gradient(sensor))]
    follows = [1.0] * len(sensor.influences)
    H = suite.measurement_matrix(
        sensor, somewhere, gradient=gradient, rate=somewhere, influences=follows
    )
    return bytes((H + 0.0).tobytes())  # no negative zero
