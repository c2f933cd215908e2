"""Memory layout of the generated filter step, and the properties on which its source depends."""

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
    """Properties of a path constraint that determine the code generated for it.

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
    """Path constraints and required 1-sigmas that the compiled filter monitors.

    Attributes
    ----------
    paths : tuple of PathMonitor
        Path constraints.
    states : tuple of int
        Indices of the states with a required 1-sigma. If there are any, an additional value counts
        the consecutive samples, up to the current sample, at which all required 1-sigmas are
        satisfied.
    """

    paths: tuple[PathMonitor, ...] = ()
    states: tuple[int, ...] = ()

    @property
    def n_values(self) -> int:
        return len(self.paths) + bool(self.states)


NO_MONITORS = Monitors()


class Layout(NamedTuple):
    """Memory layout of the compiled filter. Each field is the index in the workspace at which a
    quantity, such as the transition matrix, begins.

    The slots are those of one candidate, in increasing order. The covariance starts at slot 0.
    Covariance, attitude and monitored values are the state of a candidate, from which a run can be
    continued.

    Attributes
    ----------
    attitude : int
        GCRS-to-body matrix, 9 values.
    monitors : int
        Values of `Monitors`.
    rotation, F, Q : int
        Rotation matrix, transition and process noise of one step of the current maneuver.
    axis_angle : int
        Unit axis, angle, sine and cosine of the rotation in one step; only with path constraints.
    squared_rate : int
        Squared body rate [rad²/s²]; only if a sensor has a maximum rate.
    body_rate : int
        Body rate [rad/s]; only if a sensor has a measurement latency.
    trace, pivot : int
        Results of the compiled functions ``step`` and ``check``.
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
    """Compute the index at which each quantity of the compiled filter begins in the workspace.

    Parameters
    ----------
    suite : Suite
    gated : tuple of bool
        For each sensor, whether it is unavailable at some samples.
    monitors : Monitors
        Path constraints and required 1-sigmas to monitor.
    """
    n_states, n_kinematic = suite.n_states, suite.n_kinematic
    n_columns = compute_table_columns(suite, gated, monitors)["end"]
    n_transition = len(compute_transition_pattern(suite))
    has_rate = any(sensor.get_max_rate() < np.inf for sensor in suite.sensors)
    state_sizes, maneuver_sizes = (
        [count_slots(n_states), 9, monitors.n_values],
        [9, n_transition, count_slots(n_kinematic)],
    )
    has_latency = any(sensor.latency_states() for sensor in suite.sensors)
    optional_sizes = [6 if monitors.paths else 0, int(has_rate), 3 if has_latency else 0]
    return Layout(
        *accumulate(
            [*state_sizes, *maneuver_sizes, *optional_sizes, 1, 1, count_slots(n_states), n_columns]
        )
    )


def compute_table_columns(
    suite: Suite, gated: tuple[bool, ...], monitors: Monitors = NO_MONITORS
) -> dict[str, int]:
    """Return the first column of each group of columns in `FilterModel.orbit_table`, keyed by
    group.

    The additional key ``end`` gives the total number of columns. The groups are, in this order:

    - ``references``: reference vectors and auxiliary vectors of the sensors.
    - ``path NAME``, for each direction of a path constraint: the direction at the sample, the
      change of the direction in the preceding step, and 1 if the direction appears in that step;
      for a disc also the radius and the change of the radius.
    - ``view NAME``, for each direction of a field of view: the direction at the sample; for a disc
      also the cosine and sine of the radius.
    - ``sensitivity_factors``: factors of the bias sensitivities.
    - ``available``: availability of each sensor that is unavailable at some samples.
    """
    widths = {"references": 3 * suite.n_vectors}
    for name in list_path_directions(monitors):
        widths[f"path {name}"] = 9 if is_disc(name) else 7
    for name in list_view_directions(suite):
        widths[f"view {name}"] = 5 if is_disc(name) else 3
    widths |= {
        "sensitivity_factors": len(suite.sensitivities_by_key),
        "available": sum(gated),
        "end": 0,
    }
    return dict(zip(widths, accumulate([0, *widths.values()]), strict=False))


def list_directions(suite: Suite, monitors: Monitors = NO_MONITORS) -> tuple[str, ...]:
    """List the reference directions, such as ``sun``, that path constraints and sensors use.

    Each name occurs once.
    """
    return tuple(dict.fromkeys([*list_path_directions(monitors), *list_view_directions(suite)]))


def list_path_directions(monitors: Monitors) -> tuple[str, ...]:
    """List the reference directions, such as ``sun``, that path constraints use.

    Each name occurs once.
    """
    return tuple(dict.fromkeys(monitor.direction for monitor in monitors.paths))


def list_view_directions(suite: Suite) -> tuple[str, ...]:
    """List the reference directions, such as ``sun``, that the visibility cones of sensors use.

    Each name occurs once.
    """
    names = (cone.direction for sensor in suite.sensors for cone in sensor.list_visibility_cones())
    return tuple(dict.fromkeys(name for name in names if name))


def is_disc(name: str) -> bool:
    """Return True if the object in a named direction appears as a disc, such as the Earth."""
    return DIRECTIONS[name].radius is not None


@cache
def compute_transition_pattern(suite: Suite) -> tuple[tuple[int, int], ...]:
    """Return the (row, column) pairs of transition-matrix entries that can be nonzero.

    The transition matrix is exp(A dt) with the dynamics matrix A. The pattern is the transitive
    closure of the pattern of A over all body rates. A state without dynamics and process noise has
    a row of the identity matrix, which is omitted.
    """
    n_kinematic = suite.n_kinematic
    pattern = np.zeros((n_kinematic, n_kinematic), dtype=bool)
    for omega in np.vstack([np.zeros(3), np.eye(3)]):
        pattern |= suite.dynamics_matrix(omega)[:n_kinematic, :n_kinematic] != 0.0
    closure = pattern | np.eye(n_kinematic, dtype=bool)
    for _ in range(n_kinematic):
        closure = closure @ closure
    has_row = pattern.any(axis=1) | (suite.compute_noise_density()[:n_kinematic] > 0.0)
    return tuple((int(i), int(j)) for i, j in np.argwhere(closure) if has_row[i])


class KernelTraits(NamedTuple):
    """Properties of a model that determine the source of its compiled filter.

    Models with equal properties share one compiled filter.

    Attributes
    ----------
    states : tuple of str
        Names of the 3-vectors of the state.
    considered_states : tuple of int
        States that are not estimated.
    directions_in_view : tuple of (str, bool)
        Directions of path constraints and fields of view, and whether each must be inside its cone.
    number_of_constants : int
        Number of step constants of instruments and path constraints.
    measurements : tuple of bytes
        Measurement matrix of each sensor, see `serialize_measurement_matrix`.
    """

    states: tuple[str, ...]
    considered_states: tuple[int, ...]
    directions_in_view: tuple[tuple[str, bool], ...]
    number_of_constants: int
    measurements: tuple[bytes, ...]


@lru_cache(maxsize=1000)
def serialize_measurement_matrix(sensor: Sensor, environment_errors: EnvironmentErrors) -> bytes:
    """Return the measurement matrix of a sensor at a test attitude, as bytes for comparison.

    The generated code contains the coefficients of the measurement model. Two models can share the
    code only if the bytes are equal.
    """
    suite, vector = Suite(Gyro(), (sensor,), environment_errors), np.array([0.36, -0.48, 0.8])
    auxiliary_vectors = [
        np.roll(vector, k + 1) for k in range(suite.count_auxiliary_vectors(sensor))
    ]
    deviations = [1.0] * len(sensor.bias_sensitivities)
    H = suite.measurement_matrix(
        sensor,
        vector,
        auxiliary_vectors=auxiliary_vectors,
        rate=vector,
        channel_deviations=deviations,
    )
    return bytes((H + 0.0).tobytes())  # Adding zero removes the sign of negative zeros.
