"""Code generation for one filter step of a sensor suite.

A step has several parts: rotate the attitude and predict the covariance, update with each sensor,
and compute the trace. The generated source describes one candidate. `lanewise.py` compiles the
source for all candidates in a vector register. All values of all candidates are in one flat
workspace ``W`` at constant offsets (`layout.py`). `driver.py` calls the compiled step.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial, reduce
from itertools import count, islice
from typing import Any

import numpy as np

from mgeo_attitude.filter import covariance
from mgeo_attitude.filter.layout import (
    NO_MONITORS,
    Monitors,
    build_layout,
    compute_table_columns,
    compute_transition_pattern,
    list_path_directions,
)
from mgeo_attitude.filter.path_constraints import (
    StepRotation,
    build_monitored_angle,
    find_extreme_point,
    list_cone_constants,
)
from mgeo_attitude.filter.symbols import Code, Symbol, Triangle, slot_index
from mgeo_attitude.geometry.vector import Vec3, dot, maximum
from mgeo_attitude.scenario.constraints import PathConstraint
from mgeo_attitude.sensors.suite import Suite

CHECK_PART = "check"


def build_step_parts(
    suite: Suite,
    gated: tuple[bool, ...],
    monitors: Monitors = NO_MONITORS,
) -> dict[str, str]:
    """Generate the Python source of one step of the covariance filter, as a dict keyed by part.

    The result maps the name of each part, such as ``propagate`` or ``update_0``, to its source, in
    execution order. The source describes one candidate. It consists of assignments to names and to
    workspace values ``W[k]``, and of loops over such assignments. The part `CHECK_PART` is not
    executed in every step: it computes the last Cholesky pivot of the covariance. A step is split
    into parts because compile time grows faster than linearly with the size of a function.

    Parameters
    ----------
    suite : Suite
    gated : tuple of bool
        For each sensor, whether it is unavailable at some samples.
    monitors : Monitors, optional
        Path constraints and required 1-sigmas to monitor.

    Returns
    -------
    dict of str to str
        Source by the name of the part.
    """
    step = _StepBuilder(suite, gated, monitors)
    _propagate(step)
    if monitors.paths:
        # The attitude during a step is controlled with the estimates before its measurements.
        _monitor_paths(step)
    for index in range(len(suite.sensors)):
        _update(step, index)
    if monitors.states:
        _monitor_states(step)
    _sum_trace(step)
    code = step.find_part(CHECK_PART)
    code.store(
        step.slots.pivot, covariance.compute_last_pivot(step.build_triangle(code), suite.n_states)
    )
    return {name: code.text for name, code in step.parts.items()}


class _StepBuilder:
    """Builder of the generated code for one filter step.

    Its methods return symbols for the quantities that the step reads from the workspace.
    """

    def __init__(self, suite: Suite, gated: tuple[bool, ...], monitors: Monitors) -> None:
        self.suite, self.gated, self.monitors = suite, gated, monitors
        self.slots = build_layout(suite, gated, monitors)
        self.parts: dict[str, Code] = {}
        self._columns = compute_table_columns(suite, gated, monitors)
        self._constants = count(self.slots.constants)

    def find_part(self, name: str) -> Code:
        return self.parts.setdefault(name, Code())

    def build_triangle(self, code: Code) -> Triangle:
        return Triangle(code, self.slots.scratch)

    def take_constants(self, code: Code, n_constants: int) -> list[Symbol]:
        """Return code symbols for the next `n_constants` constants that the filter step reads.

        Successive calls return the constants in the order of `variants.stack_constants`.
        """
        return [code.slot(k) for k in islice(self._constants, n_constants)]

    def select_table_values(
        self, code: Code, group: str, first: int, count: int
    ) -> Sequence[Symbol]:
        """Return code symbols for `count` consecutive values in the orbit-table row of the current
        step.

        The values start at column `first` of the named group of columns.
        """
        return code.slots(self.slots.table + self._columns[group] + first, count)

    def rotate_to_body(self, code: Code, vector: Iterable[Any]) -> Vec3:
        C, v = code.slots(self.slots.attitude, 9), tuple(vector)
        return Vec3(*(sum(C[3 * i + k] * v[k] for k in range(3)) for i in range(3)))

    def load_body_vector(self, code: Code, group: str, index: int = 0) -> Vec3:
        """Return code symbols for a vector in the orbit table, such as the Sun direction, in body
        axes.

        The vector has the number `index` in the named group of columns.
        """
        return self.rotate_to_body(code, self.select_table_values(code, group, 3 * index, 3))

    def load_gate(self, code: Code, index: int) -> Any:
        if not self.gated[index]:
            return 1.0
        return code.slot(self.slots.constants - sum(self.gated[index:]))


def _propagate(step: _StepBuilder) -> None:
    code, slots, suite = step.find_part("propagate"), step.slots, step.suite
    C, dC = code.slots(slots.attitude, 9), code.slots(slots.rotation, 9)
    for j in range(3):
        column = [sum(dC[3 * i + k] * C[3 * k + j] for k in range(3)) for i in range(3)]
        for i in range(3):
            code.store(slots.attitude + 3 * i + j, column[i])
    F = {entry: code.slot(slots.F + k) for k, entry in enumerate(compute_transition_pattern(suite))}
    for k, states in enumerate(suite.gyro_sensitivity_slices):
        (value,) = step.select_table_values(code, "sensitivity_factors", k, 1)
        columns = range(states.start, states.stop)
        F |= {(i, j): factor * value for (i, j), factor in F.items() if i != j and j in columns}
    n_kinematic = suite.n_kinematic
    Q = {
        (i, j): code.slot(slots.Q + slot_index(i, j))
        for i in range(n_kinematic)
        for j in range(i + 1)
    }
    for first in range(n_kinematic, suite.n_dynamic, 3):
        decay, *variances = step.take_constants(code, 4)
        F |= {(i, i): decay for i in range(first, first + 3)}
        Q |= {(first + i, first + i): variance for i, variance in enumerate(variances)}
    covariance.predict(step.build_triangle(code), suite.n_states, F, Q)


def _monitor_paths(step: _StepBuilder) -> None:
    code, slots, path_monitors = step.find_part("monitor_paths"), step.slots, step.monitors.paths
    x, y, z, *angle = code.slots(slots.axis_angle, 6)
    rotation = StepRotation(Vec3(x, y, z), *angle)
    motions = {
        name: [step.load_body_vector(code, f"path {name}", index) for index in range(2)]
        for name in list_path_directions(step.monitors)
    }
    for k, monitor in enumerate(path_monitors):
        v, change = motions[monitor.direction]
        value, axis = code.slot(slots.monitors + k), Vec3(*step.take_constants(code, 3))
        n_disc_values = 2 * monitor.is_disc
        appears, *disc_values = step.select_table_values(
            code, f"path {monitor.direction}", 6, 1 + n_disc_values
        )
        extreme = find_extreme_point(axis, monitor.keep_in, rotation, v, change, appears)
        at_extreme, at_end = (
            (extreme.rotate_to_end(axis), extreme.interpolate_direction(v, change)),
            (axis, v),
        )
        sigmas = step.take_constants(code, 1)[0] if monitor.has_margin else None
        limb = None
        if monitor.is_disc:
            radius, radius_change = disc_values
            limb = radius - extreme.remaining_fraction * radius_change
        monitored_angle = build_monitored_angle(
            at_extreme, at_end, sigmas, limb, Triangle(code), monitor.keep_in, value
        )
        code.store(slots.monitors + k, monitored_angle)


def _update(step: _StepBuilder, index: int) -> None:
    """Generate code for the measurement update with one sensor.

    The update leaves the covariance unchanged at a sample at which the sensor cannot measure.
    """
    suite, sensor, code = step.suite, step.suite.sensors[index], step.find_part(f"update_{index}")
    rate = Vec3(*code.slots(step.slots.body_rate, 3))
    vector = step.load_body_vector(code, "references", index)
    variances = step.take_constants(code, len(sensor.noise_sigmas()))
    rows = suite.find_auxiliary_rows(index)
    auxiliary_vectors = [
        step.load_body_vector(code, "references", k) for k in range(rows.start, rows.stop)
    ]
    gate = step.load_gate(code, index)
    for cone in sensor.list_visibility_cones():
        boresight, (bound,) = Vec3(*step.take_constants(code, 3)), step.take_constants(code, 1)
        if cone.is_disc:  # The bound is the cosine of the sum of half-angle and radius.
            cosine, sine = step.select_table_values(code, f"view {cone.direction}", 3, 2)
            bound = bound * cosine - step.take_constants(code, 1)[0] * sine
        direction = (
            step.load_body_vector(code, f"view {cone.direction}") if cone.direction else vector
        )
        inside = float(cone.keep_in)
        gate = gate * dot(boresight, direction).choose(bound, inside, 1.0 - inside)
    if sensor.get_max_rate() < np.inf:
        gate = gate * step.take_constants(code, 1)[0].choose(
            code.slot(step.slots.squared_rate), 1.0, 0.0
        )
    sensitivity_columns = suite.find_sensitivity_columns(sensor)
    measure = partial(
        suite.apply_measurement_matrix,
        sensor,
        vector,
        to_body=partial(step.rotate_to_body, code),
        auxiliary_vectors=auxiliary_vectors,
        rate=rate,
        channel_deviations=step.select_table_values(
            code,
            "sensitivity_factors",
            sensitivity_columns.start,
            sensitivity_columns.stop - sensitivity_columns.start,
        ),
    )
    considered = frozenset(suite.considered_indices.tolist())
    P = step.build_triangle(code)
    covariance.update(P, suite.n_states, measure, variances, gate, considered)


def _monitor_states(step: _StepBuilder) -> None:
    """Generate code that counts consecutive samples at which all required 1-sigmas are satisfied.

    The count ends at the current sample.
    """
    code, states = step.find_part("monitor_states"), step.monitors.states
    weights = step.take_constants(code, len(states))
    ratios = [
        code.slot(slot_index(i, i)) * weight for i, weight in zip(states, weights, strict=True)
    ]
    largest_ratio = reduce(maximum, ratios)
    count_slot = step.slots.monitors + len(step.monitors.paths)
    n_satisfied = (-largest_ratio).choose(-1.0, code.slot(count_slot) + 1.0, 0.0)
    code.store(count_slot, n_satisfied)


def _sum_trace(step: _StepBuilder) -> None:
    code, n = step.find_part("sum_trace"), step.suite.n_states
    P, weights = Triangle(code), step.take_constants(code, n)
    code.store(step.slots.trace, sum(weights[i] * P[i, i] for i in range(n)))


def compute_instrument_constants(
    suite: Suite, step: float, path_constraints: Sequence[PathConstraint] = ()
) -> np.ndarray:
    """Return the constants of a filter step that depend on instruments and path constraints, such
    as noise variances.

    The constants are, in this order: decay factor and process-noise variances of each Gauss-Markov
    process; the constants of the path constraints (`path_constraints.list_cone_constants`); and for
    each sensor its noise variances, the axis and the cosine of the half-angle of each visibility
    cone (followed by the sine if the cone refers to a disc), and the square of its maximum rate if
    the sensor has a maximum rate.

    Parameters
    ----------
    suite : Suite
    step : float
        Filter step [s].
    path_constraints : sequence of PathConstraint, optional

    Returns
    -------
    array, shape (n_constants,)
    """
    processes: list[float] = []
    for process in suite.processes.values():
        decay, variance = process.discretize(step)
        processes.extend([decay, *np.broadcast_to(variance, 3)])
    values: list[float] = []
    for sensor in suite.sensors:
        values.extend(sigma**2 for sigma in sensor.noise_sigmas())
        for cone in sensor.list_visibility_cones():
            values.extend([*cone.axis, float(np.cos(cone.half_angle))])
            values.extend([float(np.sin(cone.half_angle))] * cone.is_disc)
        if sensor.get_max_rate() < np.inf:
            values.append(sensor.get_max_rate() ** 2)
    return np.concatenate([processes, list_cone_constants(path_constraints), values])


def build_module_source(
    suite: Suite, gated: tuple[bool, ...], monitors: Monitors, n_lanes: int
) -> str:
    """Generate the source of a Python module with the compiled filter step of a sensor suite.

    The function ``step(W)`` of the module advances all candidates in the workspace W by one step.
    The function ``check(W)`` computes the last Cholesky pivot of each covariance.

    Parameters
    ----------
    suite, gated, monitors
        See `build_step_parts`.
    n_lanes : int
        Candidates per vector register.
    """
    parts = build_step_parts(suite, gated, monitors)
    functions = "\n\n".join(
        f'{name} = lanewise("""\n{text}\n""", {n_lanes})' for name, text in parts.items()
    )
    step = "\n".join(f"    {name}(W)" for name in parts if name != CHECK_PART)
    return f'''"""Filter step of {suite.n_states} states. Generated; do not edit."""

from numba import cfunc

from {__package__}.lanewise import lanewise

{functions}

@cfunc("{_SIGNATURE}", cache=True)
def step(W):
{step}

@cfunc("{_SIGNATURE}", cache=True)
def check(W):
    {CHECK_PART}(W)
'''


# The argument is a pointer, because a function of an array takes three times as long to compile.
_SIGNATURE = "void(CPointer(float64))"
