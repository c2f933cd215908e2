"""Parameters of a generated kernel, and the slots of a candidate's values in its workspace."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from mgeo_attitude.environment.directions import DIRECTIONS
from mgeo_attitude.filter.symbols import count_slots
from mgeo_attitude.scenario.constraints import PathConstraint
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.environment_errors import EnvironmentErrors
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.suite import Suite


class PathMonitor(NamedTuple):
    """Path constraint as a kernel monitors it; the monitored value is `path_limits.excess` [rad].

    Attributes
    ----------
    direction : str
        Name of the direction.
    keep_in : bool
        Whether the direction must stay inside the cone.
    is_disc : bool
        Whether the angle is measured from the limb of a disc.
    has_margin : bool
        Whether a margin for the attitude uncertainty applies.
    """

    direction: str
    keep_in: bool
    is_disc: bool
    has_margin: bool

    @classmethod
    def from_constraint(cls, constraint: PathConstraint) -> PathMonitor:
        cone = constraint.build_cone()
        return cls(cone.direction, cone.keep_in, cone.is_disc, constraint.attitude_sigmas > 0.0)


@dataclass(frozen=True)
class Monitors:
    """Quantities monitored along every run in addition to the filter.

    Attributes
    ----------
    paths : tuple of Watch
        Path constraints.
    states : tuple of int
        States with a required 1-sigma. If there are any, one more value counts the consecutive
        samples, up to the current one, at which all requirements are satisfied.
    """

    paths: tuple[PathMonitor, ...] = ()
    states: tuple[int, ...] = ()

    @property
    def n_values(self) -> int:
        return len(self.paths) + bool(self.states)


NO_MONITORS = Monitors()


class Layout(NamedTuple):
    """First workspace slot of each kind of value, in increasing order.

    Slot 0 starts the covariance. Covariance, `attitude` and `monitors` are the state of a
    candidate.

    Attributes
    ----------
    attitude : int
        GCRS-to-body matrix, 9 values.
    monitors : int
        See `Monitors`.
    rotation, F, Q : int
        Rotation matrix, transition and process noise of one step of the current maneuver.
    turn : int
        Unit axis, angle, sine and cosine of the rotation in one step; only with path constraints.
    squared_rate : int
        Squared body rate [rad²/s²]; only if a sensor has a maximum rate.
    body_rate : int
        Body rate [rad/s]; only if a sensor has a measurement latency.
    trace, pivot : int
        Results of ``step`` and ``check``.
    scratch : int
        Intermediate values of loops.
    table : int
        Row of the orbit table, see `compute_table_columns`.
    constants : int
        Constants of the model variant, see `variants.stack_constants`.
    """

    attitude: int
    monitors: int
    rotation: int
    F: int
    Q: int
    axis_angle: int
    squared_rate: int
    body_rate: int
    trace: int
    pivot: int
    scratch: int
    table: int
    constants: int


@cache
def build_layout(suite: Suite, gated: tuple[bool, ...], monitors: Monitors = NO_MONITORS) -> Layout:
    """Return the workspace layout of a suite.

    Parameters
    ----------
    suite : Suite
    gated : tuple of bool
        For each sensor, whether it is unavailable at some samples.
    monitors : Monitors
    """
    n, m = suite.n_states, suite.n_kinematic
    given = compute_table_columns(suite, gated, monitors)["end"]
    n_transition = len(compute_transition_pattern(suite))
    has_rate = any(sensor.max_rate() < np.inf for sensor in suite.sensors)
    state, maneuver = [count_slots(n), 9, monitors.n_values], [9, n_transition, count_slots(m)]
    has_latency = any(sensor.latency_states() for sensor in suite.sensors)
    optional = [6 if monitors.paths else 0, int(has_rate), 3 if has_latency else 0]
    return Layout(*accumulate([*state, *maneuver, *optional, 1, 1, count_slots(n), given]))


def compute_table_columns(
    suite: Suite, gated: tuple[bool, ...], monitors: Monitors = NO_MONITORS
) -> dict[str, int]:
    """Return the first column of each part of `FilterModel.table`, and the width as ``end``.

    The parts are, in order:

    - ``references``: vectors measured by the sensors, and their gradients.
    - ``off NAME``, for each direction of a path constraint: the direction at the sample, its change
      in the step before, and 1 if it appears in that step; for a disc also the radius and its
      change.
    - ``view NAME``, for each direction of a field of view: the direction at the sample; for a disc
      also the cosine and sine of the radius.
    - ``bias_sensitivities``: factors of the bias sensitivities.
    - ``available``: availability of each gated sensor.
    """
    widths = {"references": 3 * suite.n_vectors}
    for name in list_path_directions(monitors):
        widths[f"off {name}"] = 9 if is_disc(name) else 7
    for name in list_view_directions(suite):
        widths[f"view {name}"] = 5 if is_disc(name) else 3
    widths |= {
        "sensitivity_factors": len(suite.sensitivities_by_key),
        "available": sum(gated),
        "end": 0,
    }
    return dict(zip(widths, accumulate([0, *widths.values()]), strict=False))


def list_directions(suite: Suite, monitors: Monitors = NO_MONITORS) -> tuple[str, ...]:
    """Return the directions of path constraints and of fields of view, without duplicates."""
    return tuple(dict.fromkeys([*list_path_directions(monitors), *list_view_directions(suite)]))


def list_path_directions(monitors: Monitors) -> tuple[str, ...]:
    """Return the directions of path constraints, without duplicates."""
    return tuple(dict.fromkeys(watch.direction for watch in monitors.paths))


def list_view_directions(suite: Suite) -> tuple[str, ...]:
    """Return the directions of the sensors' fields of view, without duplicates."""
    names = (view.direction for sensor in suite.sensors for view in sensor.list_visibility_cones())
    return tuple(dict.fromkeys(name for name in names if name))


def is_disc(name: str) -> bool:
    """Return whether a direction points to a disc with an apparent radius."""
    return DIRECTIONS[name].radius is not None


@cache
def compute_transition_pattern(suite: Suite) -> tuple[tuple[int, int], ...]:
    """Return the (row, column) entries of exp(A dt) that can be nonzero, without constant rows.

    The entries are the transitive closure of the pattern of A at any rate. A state without dynamics
    and process noise has a row of the identity, which is left out.
    """
    k = suite.n_kinematic
    generic = np.zeros((k, k), dtype=bool)
    for omega in np.vstack([np.zeros(3), np.eye(3)]):
        generic |= suite.dynamics_matrix(omega)[:k, :k] != 0.0
    closure = generic | np.eye(k, dtype=bool)
    for _ in range(k):
        closure = closure @ closure
    rows = generic.any(axis=1) | (suite.compute_noise_density()[:k] > 0.0)
    return tuple((int(i), int(j)) for i, j in np.argwhere(closure) if rows[i])


class KernelTraits(NamedTuple):
    """Properties that determine a compiled kernel: models with equal traits share a kernel.

    Attributes
    ----------
    states : tuple of str
        Blocks of the suite.
    considered_states : tuple of int
        States that are not estimated.
    directions_in_view : tuple of (str, bool)
        Directions of path constraints and fields of view, and whether they must be inside.
    number_of_constants : int
        Number of step constants of instruments and path constraints.
    measurements : tuple of bytes
        Measurement matrix of each sensor, see `slopes`.
    """

    states: tuple[str, ...]
    considered_states: tuple[int, ...]
    directions_in_view: tuple[tuple[str, bool], ...]
    number_of_constants: int
    measurements: tuple[bytes, ...]


@lru_cache(maxsize=1000)
def serialize_measurement_matrix(sensor: Sensor, world: EnvironmentErrors) -> bytes:
    """Return the bytes of a sensor's measurement matrix at a fixed test attitude.

    The kernel contains the numbers of the measurement model, so equal bytes are required to share
    it.
    """
    suite, somewhere = Suite(Gyro(), (sensor,), world), np.array([0.36, -0.48, 0.8])
    gradient = [np.roll(somewhere, k + 1) for k in range(suite.count_gradient_vectors(sensor))]
    follows = [1.0] * len(sensor.bias_sensitivities)
    H = suite.measurement_matrix(
        sensor, somewhere, gradient=gradient, rate=somewhere, channel_deviations=follows
    )
    return bytes((H + 0.0).tobytes())  # Adding zero removes the sign of negative zeros.
