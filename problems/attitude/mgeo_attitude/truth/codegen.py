"""Generates what a simulation needs of a sensor suite, from what its sensors and gyro declare.

Straight-line functions over flat arrays, one for each sensor: what it measures, and the innovation
with its first and second derivatives in the errors of the estimate. What calls them is the text of
`correction.py` and `driver.py`, appended as it stands.

The error of an estimate is attitude, gyro and sensor states in the order of the suite. That of the
attitude and of a state that is a rotation is a rotation itself: C = R(-θ) Ĉ for the matrix from
GCRS to body, and R(φ) = R(φ̂) R(Δφ) for a misalignment. That of any other state is a difference.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import resources
from types import SimpleNamespace
from typing import Any

from ..filter.suite import Suite
from ..filter.symbols import Symbol, SymbolArithmetic
from ..rotation import Matrix, rotate
from ..sensors import Sensor
from ..vector import AXES, Vec3
from .jets import Jet, variable

_DECORATOR = '@njit(error_model="numpy", cache=CACHE)'


@dataclass(frozen=True)
class Local:
    """Error states that a sensor's measurement depends on: attitude first, then its own.

    Attributes
    ----------
    states : tuple of int
        Their numbers in the suite's state.
    curved : tuple of int
        Numbers, within `states`, of those that the measurement is not linear in.
    """

    states: tuple[int, ...]
    curved: tuple[int, ...]


def rotation_blocks(suite: Suite) -> tuple[int, ...]:
    """First states of the 3-vectors that are rotations, that of the attitude first."""
    names = ["attitude"]
    names += [f"gyro.{state}" for state in suite.gyro.states() if state in suite.gyro.rotations]
    for sensor in suite.sensors:
        names += [f"{sensor.name}.{s}" for s in sensor.states() if s in sensor.rotations]
    return tuple(3 * suite.blocks.index(name) for name in names)


def module_source(suite: Suite, truth: Suite, cache: bool) -> str:
    """Source of the simulation's compiled module.

    Parameters
    ----------
    suite : Suite
        What the estimator believes in.
    truth : Suite
        What reports, with the same states.
    """
    parts, locals_ = [], []
    for index, (sensor, real) in enumerate(zip(suite.sensors, truth.sensors, strict=True)):
        parts.append(_measured(truth, index, real))
        text, local = _innovation(suite, index, sensor)
        parts.append(text)
        locals_.append(local)
    parts += [_dispatch(len(locals_), "measured", "v, C, x, y")]
    parts += [_dispatch(len(locals_), "innovation", "y, v, C, x, r, H, B")]
    parts += [_gyro(truth, "gyro_measured", truth.gyro.measured)]
    parts += [_gyro(suite, "gyro_corrected", suite.gyro.corrected)]
    correction, driver = _text("correction.py"), _text("driver.py")
    functions = "\n\n\n".join(parts)
    rotations = rotation_blocks(suite)
    n_local = max(len(local.states) for local in locals_)
    n_curved = max(len(local.curved) for local in locals_)
    return f'''"""Truth and filter for {suite.n_states} states. Generated; do not edit."""

import numpy as np
from numba import njit

CACHE = {cache}
N_STATES = {suite.n_states}
N_DYNAMIC = {suite.n_dynamic}
N_SENSORS = {len(suite.sensors)}
N_READINGS = {max(n_readings(sensor) for sensor in truth.sensors)}
ROTATIONS = np.array({rotations})
IS_ROTATION = np.array({[3 * (i // 3) in rotations for i in range(suite.n_states)]})
N_LOCAL = np.array({[len(local.states) for local in locals_]})
LOCAL = np.array({[_padded(local.states, n_local) for local in locals_]})
N_CURVED = np.array({[len(local.curved) for local in locals_]})
CURVED = np.array({[_padded(local.curved, n_curved) for local in locals_]}, dtype=np.int64)


{functions}


{correction}

{driver}'''


def n_readings(sensor: Sensor) -> int:
    """How many numbers the sensor reports."""
    zero = Vec3(0.0, 0.0, 0.0)
    x = SimpleNamespace(to_body=lambda vector: vector, **dict.fromkeys(sensor.states(), zero))
    readings = sensor.measured(x, AXES[0])
    return 3 if isinstance(readings, Vec3) else 3 * len(readings)


def _text(name: str) -> str:
    text = resources.files(__package__).joinpath(name).read_text(encoding="utf-8")
    package = (__package__ or "").rpartition(".")[0]
    return text.replace("from ..", f"from {package}.").replace("from .", f"from {__package__}.")


def _innovation(suite: Suite, index: int, sensor: Sensor) -> tuple[str, Local]:
    """Text of ``innovation_i(y, v, C, x, r, H, B)`` and what it depends on.

    With the measurement y, the reference v in estimated body axes, the estimate's attitude C and
    states x, it writes the innovation r, H = -∂r/∂e and the upper half of B = ∂²r/∂e² in the errors
    e; see `Local` for which.
    """
    ops = SymbolArithmetic()
    n_own = 3 * len(sensor.states())

    def known(array: str, first: int) -> Vec3:
        return Vec3(*(Jet(Symbol(f"{array}[{first + k}]"), ops.keep) for k in range(3)))

    def error(first: int) -> Vec3:
        return Vec3(*(variable(0.0, first + k, ops.keep) for k in range(3)))

    theta = error(0)
    own: dict[str, Any] = {}
    for number, state in enumerate(sensor.states(), start=1):
        estimate, e = (
            known("x", 3 * suite.blocks.index(f"{sensor.name}.{state}")),
            error(3 * number),
        )
        if state in sensor.rotations:
            own[state] = (_matrix(estimate, ops), e)
        else:
            own[state] = estimate + e

    def to_body(vector: Vec3) -> Vec3:
        return rotate(
            -theta, _turned(vector, lambda k: Jet(Symbol(f"C[{k // 3}, {k % 3}]"), ops.keep))
        )

    x = SimpleNamespace(to_body=to_body, **own)
    predicted = sensor.measured(x, rotate(-theta, known("v", 0)))
    readings = [known("y", 3 * k) for k in range(n_readings(sensor) // 3)]
    measured = readings[0] if isinstance(predicted, Vec3) else tuple(readings)
    r = list(sensor.innovation(measured, predicted))

    pairs = {pair for component in r for pair in component.second}
    curved = tuple(sorted({variable for pair in pairs for variable in pair}))
    for q, component in enumerate(r):
        ops.store(f"r[{q}]", component.value)
        for j in range(3 + n_own):
            ops.store(f"H[{q}, {j}]", -component.gradient(j))
        for a, i in enumerate(curved):
            for b, j in enumerate(curved[a:], start=a):
                ops.store(f"B[{q}, {a}, {b}]", component.hessian(i, j))
    states = [*range(3)]
    for state in sensor.states():
        first = 3 * suite.blocks.index(f"{sensor.name}.{state}")
        states += [first, first + 1, first + 2]
    return _function(f"innovation_{index}(y, v, C, x, r, H, B)", ops), Local(tuple(states), curved)


def _matrix(g: Vec3, ops: SymbolArithmetic) -> Matrix:
    """R(g), whose product with a jet takes fewer terms than `rotate` by g does."""
    columns = [rotate(g, Vec3(*(Jet(c, ops.keep) for c in axis))) for axis in AXES]
    return Matrix(*(Vec3(*row) for row in zip(*columns, strict=True)))


def _measured(suite: Suite, index: int, sensor: Sensor) -> str:
    """Text of ``measured_i(v, C, x, y)``, which writes the readings y."""
    ops = SymbolArithmetic()
    own = {s: _block(suite, f"{sensor.name}.{s}") for s in sensor.states()}
    x = SimpleNamespace(
        to_body=lambda vector: _turned(vector, lambda k: Symbol(f"C[{k // 3}, {k % 3}]")),
        **{state: _kept(value, ops) for state, value in own.items()},
    )
    readings = sensor.measured(x, _kept(Vec3(*(Symbol(f"v[{k}]") for k in range(3))), ops))
    vectors = [readings] if isinstance(readings, Vec3) else list(readings)
    for k, entry in enumerate(entry for vector in vectors for entry in vector):
        ops.store(f"y[{k}]", entry)
    return _function(f"measured_{index}(v, C, x, y)", ops)


def _gyro(suite: Suite, name: str, function: Callable[[Any, Vec3], Vec3]) -> str:
    """Text of ``name(rate, x, out)`` for `Gyro.measured` or `Gyro.corrected`."""
    ops = SymbolArithmetic()
    own = {s: _kept(_block(suite, f"gyro.{s}"), ops) for s in suite.gyro.states()}
    rate = _kept(Vec3(*(Symbol(f"rate[{k}]") for k in range(3))), ops)
    for k, entry in enumerate(function(SimpleNamespace(**own), rate)):
        ops.store(f"out[{k}]", entry)
    return _function(f"{name}(rate, x, out)", ops)


def _block(suite: Suite, name: str) -> Vec3:
    first = 3 * suite.blocks.index(name)
    return Vec3(*(Symbol(f"x[{first + k}]") for k in range(3)))


def _kept(v: Vec3, ops: SymbolArithmetic) -> Vec3:
    return Vec3(*(ops.keep(component) for component in v))


def _turned(v: Vec3, entry: Callable[[int], Any]) -> Vec3:
    """C v for the entries of a 3 x 3 matrix, row by row."""
    return Vec3(
        *(entry(3 * i) * v.x + entry(3 * i + 1) * v.y + entry(3 * i + 2) * v.z for i in range(3))
    )


def _dispatch(count: int, name: str, arguments: str) -> str:
    lines = [f"    if sensor == {i}:\n        {name}_{i}({arguments})" for i in range(count)]
    return "\n".join([_DECORATOR, f"def {name}(sensor, {arguments}):", *lines])


def _function(head: str, ops: SymbolArithmetic) -> str:
    return "\n".join([_DECORATOR, f"def {head}:", *(f"    {line}" for line in ops.lines)])


def _padded(numbers: Sequence[int], length: int) -> list[int]:
    return [*map(int, numbers), *[0] * (length - len(numbers))]
