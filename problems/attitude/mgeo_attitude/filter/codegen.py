"""Code generation for one filter step of a sensor suite.

A step consists of a few parts: rotate the attitude and predict the covariance, update with each
sensor, sum the trace. The generated text describes one candidate; `lanewise.py` compiles it for as
many candidates as a vector register holds. All values of all candidates are in one flat workspace
``W`` at constant offsets (`layout.py`). `driver.py` calls the compiled step.
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
    build_violation,
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
    """Return the source of each part of a filter step, in execution order, and of `CHECK_PART`.

    The source describes one candidate: assignments to names and to workspace values ``W[k]``, and
    loops over such assignments. `CHECK_PART` is not part of the step; it computes the last Cholesky
    pivot of the covariance. A step is split into parts because compile time grows faster than
    linearly with the size of a function.

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
        # The attitude is controlled with the estimates from before the measurements.
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
    """Parts of the step under construction, with access to their workspace values."""

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
        """Return the next `n_constants` constants, in the order of `variants.stack_constants`."""
        return [code.slot(k) for k in islice(self._constants, n_constants)]

    def select_table_values(
        self, code: Code, part: str, first: int, count: int
    ) -> Sequence[Symbol]:
        """Return `count` values of a named part of the orbit table, from column `first` on."""
        return code.slots(self.slots.table + self._columns[part] + first, count)

    def rotate_to_body(self, code: Code, vector: Iterable[Any]) -> Vec3:
        C, v = code.slots(self.slots.attitude, 9), tuple(vector)
        return Vec3(*(sum(C[3 * i + k] * v[k] for k in range(3)) for i in range(3)))

    def load_body_vector(self, code: Code, part: str, index: int = 0) -> Vec3:
        """Return a vector of a named part of the orbit table, rotated to body axes."""
        return self.rotate_to_body(code, self.select_table_values(code, part, 3 * index, 3))

    def load_gate(self, code: Code, index: int) -> Any:
        if not self.gated[index]:
            return 1.0
        return code.slot(self.slots.constants - sum(self.gated[index:]))


def _propagate(step: _StepBuilder) -> None:
    code, at, suite = step.find_part("propagate"), step.slots, step.suite
    C, dC = code.slots(at.attitude, 9), code.slots(at.rotation, 9)
    for j in range(3):
        column = [sum(dC[3 * i + k] * C[3 * k + j] for k in range(3)) for i in range(3)]
        for i in range(3):
            code.store(at.attitude + 3 * i + j, column[i])
    F = {entry: code.slot(at.F + k) for k, entry in enumerate(compute_transition_pattern(suite))}
    for k, followed in enumerate(suite.gyro_sensitivity_slices):
        (value,) = step.select_table_values(code, "sensitivity_factors", k, 1)
        own = range(followed.start, followed.stop)
        F |= {(i, j): factor * value for (i, j), factor in F.items() if i != j and j in own}
    m = suite.n_kinematic
    Q = {(i, j): code.slot(at.Q + slot_index(i, j)) for i in range(m) for j in range(i + 1)}
    for first in range(m, suite.n_dynamic, 3):
        decay, *variances = step.take_constants(code, 4)
        F |= {(i, i): decay for i in range(first, first + 3)}
        Q |= {(first + i, first + i): variance for i, variance in enumerate(variances)}
    covariance.predict(step.build_triangle(code), suite.n_states, F, Q)


def _monitor_paths(step: _StepBuilder) -> None:
    code, at, limits = step.find_part("watch_path"), step.slots, step.monitors.paths
    x, y, z, *angle = code.slots(at.axis_angle, 6)
    turn = StepRotation(Vec3(x, y, z), *angle)
    passages = {
        name: [step.load_body_vector(code, f"off {name}", index) for index in range(2)]
        for name in list_path_directions(step.monitors)
    }
    for k, watch in enumerate(limits):
        v, change = passages[watch.direction]
        value, axis = code.slot(at.monitors + k), Vec3(*step.take_constants(code, 3))
        disc = 2 * watch.is_disc
        appears, *limb_given = step.select_table_values(code, f"off {watch.direction}", 6, 1 + disc)
        extreme = find_extreme_point(axis, watch.keep_in, turn, v, change, appears)
        at_extreme, at_end = (
            (extreme.rotate_to_end(axis), extreme.interpolate_direction(v, change)),
            (axis, v),
        )
        sigmas = step.take_constants(code, 1)[0] if watch.has_margin else None
        limb = None
        if watch.is_disc:
            radius, grown = limb_given
            limb = radius - extreme.remaining_fraction * grown
        worst = build_violation(
            at_extreme, at_end, sigmas, limb, Triangle(code), watch.keep_in, value
        )
        code.store(at.monitors + k, worst)


def _update(step: _StepBuilder, index: int) -> None:
    """Update with a sensor if it is available and its field-of-view conditions are satisfied."""
    suite, sensor, code = step.suite, step.suite.sensors[index], step.find_part(f"update_{index}")
    rate = Vec3(*code.slots(step.slots.body_rate, 3))
    v = step.load_body_vector(code, "references", index)
    variances = step.take_constants(code, len(sensor.noise_sigmas()))
    rows = suite.gradient_rows(index)
    gradient = [step.load_body_vector(code, "references", k) for k in range(rows.start, rows.stop)]
    gate = step.load_gate(code, index)
    for view in sensor.list_visibility_cones():
        boresight, (bound,) = Vec3(*step.take_constants(code, 3)), step.take_constants(code, 1)
        if view.is_disc:  # The bound is the cosine of the half-angle plus the radius.
            cosine, sine = step.select_table_values(code, f"view {view.direction}", 3, 2)
            bound = bound * cosine - step.take_constants(code, 1)[0] * sine
        looked_at = step.load_body_vector(code, f"view {view.direction}") if view.direction else v
        inside = float(view.keep_in)
        gate = gate * dot(boresight, looked_at).choose(bound, inside, 1.0 - inside)
    if sensor.max_rate() < np.inf:
        gate = gate * step.take_constants(code, 1)[0].choose(
            code.slot(step.slots.squared_rate), 1.0, 0.0
        )
    follows = suite.find_sensitivity_columns(sensor)
    measure = partial(
        suite.apply_measurement_matrix,
        sensor,
        v,
        to_body=partial(step.rotate_to_body, code),
        gradient=gradient,
        rate=rate,
        channel_deviations=step.select_table_values(
            code, "sensitivity_factors", follows.start, follows.stop - follows.start
        ),
    )
    considered = frozenset(suite.considered_indices.tolist())
    P = step.build_triangle(code)
    covariance.update(P, suite.n_states, measure, variances, gate, considered)


def _monitor_states(step: _StepBuilder) -> None:
    """Count the consecutive samples with all required 1-sigmas satisfied."""
    code, states = step.find_part("watch"), step.monitors.states
    weights = step.take_constants(code, len(states))
    ratios = [code.slot(slot_index(i, i)) * each for i, each in zip(states, weights, strict=True)]
    worst = reduce(maximum, ratios)
    samples = step.slots.monitors + len(step.monitors.paths)
    met = (-worst).choose(-1.0, code.slot(samples) + 1.0, 0.0)
    code.store(samples, met)


def _sum_trace(step: _StepBuilder) -> None:
    code, n = step.find_part("sum_trace"), step.suite.n_states
    P, weights = Triangle(code), step.take_constants(code, n)
    code.store(step.slots.trace, sum(weights[i] * P[i, i] for i in range(n)))


def compute_instrument_constants(
    suite: Suite, step: float, path_constraints: Sequence[PathConstraint] = ()
) -> np.ndarray:
    """Return the step constants that depend on sensors, processes and path constraints.

    The constants are, in order: decay and process-noise variances of each Gauss-Markov process; the
    constants of the path constraints (`path_limits.list_cone_constants`); and for each sensor its noise
    variances, the axis and the cosine of the half-angle of each view (followed by the sine if the
    view refers to a disc), and the square of its maximum rate if it has one.

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
        for view in sensor.list_visibility_cones():
            values.extend([*view.axis, float(np.cos(view.half_angle))])
            values.extend([float(np.sin(view.half_angle))] * view.is_disc)
        if sensor.max_rate() < np.inf:
            values.append(sensor.max_rate() ** 2)
    return np.concatenate([processes, list_cone_constants(path_constraints), values])


def build_module_source(
    suite: Suite, gated: tuple[bool, ...], monitors: Monitors, n_lanes: int
) -> str:
    """Return the source of a suite's module, with compiled functions ``step(W)`` and ``check(W)``.

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


# The argument is a pointer because an array would take three times as long to compile.
_SIGNATURE = "void(CPointer(float64))"
