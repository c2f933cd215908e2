"""Generates the straight-line filter step of a sensor suite.

A step is a few parts: turn the attitude and predict, update with each sensor, sum the trace. The
text of a part means one candidate; `lanewise.py` compiles it for as many candidates as a vector
register holds. All values of all candidates live in one flat workspace ``W`` at constant offsets.
What feeds the lanes is the text of `lane.py` and `driver.py`, appended as it stands.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib import resources
from typing import Any

import numpy as np

from ..vector import Vec3, dot
from .covariance import last_pivot, predict, update
from .layout import NO_MONITORS, Layout, layout
from .monitors import Monitors
from .suite import Suite
from .sun_excess import sun_excess
from .symbols import Symbol, SymbolArithmetic, SymbolTriangle

CHECK = "check"


def step_parts(
    suite: Suite, gated: tuple[bool, ...], monitors: Monitors = NO_MONITORS
) -> dict[str, str]:
    """Text of a filter step of one candidate, part by part in order; and of `CHECK`.

    Every part consists of assignments to names and to values ``W[k]`` of the candidate, see
    `layout.py`. `CHECK`, which is no part of the step, finds the covariance's last pivot.

    ``R[k]`` is what the orbit gives at the step: the reference of each sensor, the Sun if monitors
    need it, and whether each gated sensor is available. ``C[k]`` is what all candidates share:
    those of the keep-out cones (`sun_excess.cone_constants`); three noise variances and, with a
    field of view, boresight and cosine of the half-angle for each sensor in turn; the requirements
    of the monitors; then the trace weight of every state.
    The compiler's time grows faster than a function: hence several parts.
    """
    at = layout(suite, gated, monitors)
    n = suite.n_states
    parts: dict[str, str] = {}
    n_constants = 0

    def slot(k: int) -> str:
        return f"W[{k}]"

    def slots(first: int, count: int) -> list[Symbol]:
        return [Symbol(slot(first + k)) for k in range(count)]

    def row(first: int, count: int) -> list[Symbol]:
        return [Symbol(f"R[{first + k}]") for k in range(count)]

    def constants(count: int) -> list[Symbol]:
        nonlocal n_constants
        n_constants += count
        return [Symbol(f"C[{k}]") for k in range(n_constants - count, n_constants)]

    def part(name: str, ops: SymbolArithmetic) -> None:
        parts[name] = "\n".join(ops.lines)

    def triangle(ops: SymbolArithmetic) -> SymbolTriangle:
        return SymbolTriangle(lambda i, j: slot(i * (i + 1) // 2 + j), ops)

    C, dC = slots(at.attitude, 9), slots(at.rotation, 9)
    ops = SymbolArithmetic()
    for j in range(3):
        column = [ops.keep(sum(dC[3 * i + k] * C[3 * k + j] for k in range(3))) for i in range(3)]
        for i in range(3):
            ops.store(C[3 * i + j].text, column[i])
    F = dict(zip(at.transition, slots(at.F, len(at.transition)), strict=True))
    entries = [(i, j) for i in range(at.n_dynamic) for j in range(i + 1)]
    Q = dict(zip(entries, slots(at.Q, len(entries)), strict=True))
    predict(triangle(ops), n, F, Q, ops)
    part("propagate", ops)

    if monitors.cones:
        # before the measurements: the attitude was flown on what was known until now
        ops = SymbolArithmetic()
        sun = row(at.gate - 3, 3)
        v = Vec3(*(ops.keep(sum(C[3 * i + k] * sun[k] for k in range(3))) for i in range(3)))
        _watch_sun(monitors, slots(at.monitors, monitors.n_cones), v, constants, triangle(ops), ops)
        part("watch_sun", ops)

    gates = iter(row(at.gate, at.n_gates))
    for index, sensor in enumerate(suite.sensors):
        ops = SymbolArithmetic()
        r = row(3 * index, 3)
        v = Vec3(*(ops.keep(sum(C[3 * i + k] * r[k] for k in range(3))) for i in range(3)))
        variances = constants(3)
        gate: Symbol | float = next(gates) if gated[index] else 1.0
        if sensor.field_of_view() is not None:
            *boresight, least = constants(4)
            cosine = sum(b * component for b, component in zip(boresight, v, strict=True))
            gate = ops.keep(gate * ops.at_least(cosine, least))
        measure = partial(suite.measure, sensor, v)
        update(triangle(ops), n, measure, variances, ops, gate)
        part(f"update_{index}", ops)

    if monitors.states:
        ops = SymbolArithmetic()
        _watch(monitors, slots, constants, at, ops)
        part("watch", ops)

    ops, weights = SymbolArithmetic(), constants(n)
    P = triangle(ops)
    ops.store(slot(at.trace), sum(weights[i] * P[i, i] for i in range(n)))
    part("sum_trace", ops)

    ops = SymbolArithmetic()
    ops.store(slot(at.pivot), last_pivot(triangle(ops), n, ops))
    part(CHECK, ops)
    return parts


def _watch_sun(
    monitors: Monitors,
    values: list[Symbol],
    sun: Vec3,
    constants: Callable[[int], list[Symbol]],
    P: SymbolTriangle,
    ops: SymbolArithmetic,
) -> None:
    for value, margin in zip(values, monitors.cones, strict=True):
        if margin:
            frame, sigmas = [Vec3(*constants(3)) for _ in range(3)], constants(1)[0]
            now = sun_excess(frame, sigmas, sun, P, value, ops)
        else:
            now = dot(Vec3(*constants(3)), sun)
        ops.store(value.text, ops.maximum(now, value))


def _watch(
    monitors: Monitors,
    slots: Callable[[int, int], list[Symbol]],
    constants: Callable[[int], list[Symbol]],
    at: Layout,
    ops: SymbolArithmetic,
) -> None:
    values = slots(at.monitors, monitors.total)
    first, *others = (
        slots(i * (i + 1) // 2 + i, 1)[0] * weight
        for i, weight in zip(monitors.states, constants(len(monitors.states)), strict=True)
    )
    worst = first
    for ratio in others:
        worst = ops.keep(ops.maximum(worst, ratio))
    samples = values[-1]
    ops.store(samples.text, (samples + 1.0) * ops.at_least(1.0, worst))


def step_constants(
    suite: Suite, weights: np.ndarray, cones: Any = (), required: Any = ()
) -> np.ndarray:
    """The array C of ``step(W, C)`` for trace `weights`, shape (n_states,).

    `cones` are the constants of the keep-out cones, `required` the 1-sigmas of the monitors.
    """
    values: list[float] = [*cones]
    for sensor in suite.sensors:
        values.extend(sigma**2 for sigma in sensor.noise())
        view = sensor.field_of_view()
        if view is not None:
            boresight, half_angle = view
            values.extend([*boresight, float(np.cos(half_angle))])
    return np.array([*values, *(sigma**-2 for sigma in required), *weights])


def module_source(
    suite: Suite, gated: tuple[bool, ...], monitors: Monitors, lanes: int, cache: bool
) -> str:
    """Source of the whole kernel module of a suite: constants, `step`, `check` and the driver."""
    at = layout(suite, gated, monitors)
    parts = step_parts(suite, gated, monitors)
    step = "\n".join(f"    {name}(W, C, R, rows)" for name in parts if name != CHECK)
    package = (__package__ or "").rpartition(".")[0]
    lane, driver = (_text(name, package) for name in ("lane.py", "driver.py"))
    return f'''"""Filter kernel for {at.n_states} states. Generated; do not edit."""

import numpy as np
from numba import njit

from {package}.filter.lanewise import lanewise

LANES = {lanes}
CACHE = {cache}
N_STATES = {at.n_states}
N_DYNAMIC = {at.n_dynamic}
F_ENTRIES = np.array({at.transition})
ATTITUDE, ROTATION, F_SLOT, Q_SLOT = {at.attitude}, {at.rotation}, {at.F}, {at.Q}
MONITORS, N_MONITORS = {at.monitors}, {at.n_monitors}
TRACE, PIVOT, N_SLOTS = {at.trace}, {at.pivot}, {at.total}


{_DIVIDER.join(_compiled(name, text, at.row) for name, text in parts.items())}


{_DECORATOR}
def step(W, C, R, rows):
{step}


{lane}

{driver}'''


def _text(name: str, package: str) -> str:
    text = resources.files(__package__).joinpath(name).read_text(encoding="utf-8")
    return text.replace("from .", f"from {package}.filter.")


_DIVIDER = "\n\n\n"
# pointers, because arrays would compile three times slower
_POINTERS = ", ".join(3 * ["CPointer(float64)"] + ["CPointer(int64)"])
_DECORATOR = f'@njit("void({_POINTERS})", nogil=True, cache=CACHE)'


def _compiled(name: str, text: str, width: int) -> str:
    return f'''{name}_lanewise = lanewise("""
{text}
""", LANES, {width})


{_DECORATOR}
def {name}(W, C, R, rows):
    {name}_lanewise(W, C, R, rows)'''
