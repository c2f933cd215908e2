"""Generates the straight-line filter step of a sensor suite.

The text of `step` is one filter step of `LANES` candidates at once: turn the attitude, predict,
update with every sensor, sum the trace. All values of all lanes live in one flat workspace ``W``,
value k of a lane at ``W[k * LANES + lane]``: constant offsets into a single array are what lets
LLVM prove the lanes independent and turn the loop over them into vector instructions
(tests/benchmarks holds the measurement). The driver that feeds the lanes is the text of
`driver.py`, appended as it stands.
"""

from __future__ import annotations

from functools import partial
from importlib import resources

import numpy as np

from ..vector import Vec3
from .covariance import last_pivot, predict, update
from .layout import layout
from .suite import Suite
from .symbols import Symbol, SymbolArithmetic, SymbolTriangle

# No nnan and ninf: a covariance that breaks down must show as NaN. No reassoc: sums are in the
# order that fuses into multiply-adds best as they are written.
_DECORATOR = """@njit(
    "void(CPointer(float64), CPointer(float64))",  # arrays would compile three times slower
    error_model="numpy",
    fastmath={"nsz", "arcp", "contract"},
    nogil=True,
    cache=CACHE,
)"""


def step_source(suite: Suite, gated: tuple[bool, ...], lanes: int) -> str:
    """Python source of ``step(W, C)``, of the parts it calls, and of ``check(W, C)``.

    Each part is a loop over the lanes. `check` finds the last pivot of every lane's covariance.

    C holds what all candidates share: three noise variances and, with a field of view, boresight
    and cosine of the half-angle for each sensor in turn; then the trace weight of every state.
    One function a part keeps the compiler, whose time grows faster than a function, quick.
    """
    at = layout(suite, gated)
    n = suite.n_states
    parts: list[str] = []
    n_constants = 0

    def slot(k: int) -> str:
        return f"W[{k * lanes} + lane]"

    def slots(first: int, count: int) -> list[Symbol]:
        return [Symbol(slot(first + k)) for k in range(count)]

    def constants(count: int) -> list[Symbol]:
        nonlocal n_constants
        n_constants += count
        return [Symbol(f"c{k}") for k in range(n_constants - count, n_constants)]

    def part(name: str, ops: SymbolArithmetic, used: list[Symbol]) -> None:
        hoisted = [f"    {symbol.text} = C[{symbol.text[1:]}]" for symbol in used]
        body = [f"        {line}" for line in ops.lines]
        head = [_DECORATOR, f"def {name}(W, C):", *hoisted, f"    for lane in range({lanes}):"]
        parts.append("\n".join([*head, *body]))

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
    part("propagate", ops, [])

    gates = iter(slots(at.gate, at.n_gates))
    for index, sensor in enumerate(suite.sensors):
        ops = SymbolArithmetic()
        r = slots(at.reference + 3 * index, 3)
        v = Vec3(*(ops.keep(sum(C[3 * i + k] * r[k] for k in range(3))) for i in range(3)))
        variances, view = constants(3), []
        gate: Symbol | float = next(gates) if gated[index] else 1.0
        if sensor.field_of_view() is not None:
            view = constants(4)
            cosine = sum(b * component for b, component in zip(view[:3], v, strict=True))
            gate = ops.keep(gate * ops.at_least(cosine, view[3]))
        measure = partial(suite.measure, sensor, v)
        update(triangle(ops), n, measure, variances, ops, gate)
        part(f"update_{index}", ops, variances + view)

    ops, weights = SymbolArithmetic(), constants(n)
    P = triangle(ops)
    ops.store(slot(at.trace), sum(weights[i] * P[i, i] for i in range(n)))
    part("sum_trace", ops, weights)

    ops = SymbolArithmetic()
    ops.store(slot(at.pivot), last_pivot(triangle(ops), n, ops))
    part("check", ops, [])

    names = ["propagate", *(f"update_{index}" for index in range(len(suite.sensors))), "sum_trace"]
    calls = [f"    {name}(W, C)" for name in names]
    return "\n\n\n".join([*parts, "\n".join([_DECORATOR, "def step(W, C):", *calls, ""])])


def step_constants(suite: Suite, weights: np.ndarray) -> np.ndarray:
    """The array C of ``step(W, C)`` for trace `weights`, shape (n_states,)."""
    values: list[float] = []
    for sensor in suite.sensors:
        values.extend(sigma**2 for sigma in sensor.noise())
        view = sensor.field_of_view()
        if view is not None:
            boresight, half_angle = view
            values.extend([*boresight, float(np.cos(half_angle))])
    return np.array([*values, *weights])


def module_source(suite: Suite, gated: tuple[bool, ...], lanes: int, cache: bool) -> str:
    """Source of the whole kernel module of a suite: constants, `step` and the driver."""
    at = layout(suite, gated)
    driver = resources.files(__package__).joinpath("driver.py").read_text(encoding="utf-8")
    package = (__package__ or "").rpartition(".")[0]
    return f'''"""Filter kernel for {at.n_states} states. Generated; do not edit."""

from math import sqrt

import numpy as np
from numba import njit

LANES = {lanes}
CACHE = {cache}
N_STATES = {at.n_states}
N_DYNAMIC = {at.n_dynamic}
F_ENTRIES = np.array({at.transition})
ATTITUDE, ROTATION, F_SLOT, Q_SLOT = {at.attitude}, {at.rotation}, {at.F}, {at.Q}
REFERENCE, N_REFERENCE = {at.reference}, {3 * at.n_references}
GATE, N_GATES = {at.gate}, {at.n_gates}
TRACE, PIVOT, N_SLOTS = {at.trace}, {at.pivot}, {at.total}


{step_source(suite, gated, lanes)}

{driver.replace("from .", f"from {package}.filter.")}'''
