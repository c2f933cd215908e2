"""Generates the step backward: slopes of what is known at the end, by what each step was.

The adjoint of the filter step, in the same style (see `codegen.py`). What is known at the end is a
function J of the covariance P; Λ is its derivative by the covariance after a step, and that by the
one before follows from it. As the gain K is the best there is, J does not change with it to first
order, so of an update P⁺ = A P Aᵀ + K R Kᵀ, A = I - K H, there remain

    Λ ← Aᵀ Λ A,    ∂J/∂H = -2 Kᵀ Λ P⁺,    K = P⁺ Hᵀ R⁻¹,

and of a prediction F P Fᵀ + Q

    Λ ← Fᵀ Λ F,    ∂J/∂F = 2 Λ F P,    ∂J/∂Q = Λ.

(Reverse accumulation, A. Griewank and A. Walther, Evaluating Derivatives, SIAM 2008, chapter 3.)
H follows the attitude's matrix C, on which it depends as c + linear terms; what turns C from step
to step is part of a maneuver, as F and Q are: `backward.py` has the derivatives of these by rates.
Whether a sensor sees what it looks at is taken as given.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache, partial
from itertools import accumulate, product
from typing import Any, NamedTuple

from mgeo_attitude.filter.codegen import (
    SIGNATURE,
    Step,
    ToBody,
    instrument_constants,
    step_parts,
)
from mgeo_attitude.filter.covariance import Sparse, looked_at, project
from mgeo_attitude.filter.layout import layout, transition_pattern
from mgeo_attitude.filter.symbols import Code, Index, Symbol, Triangle, slots_of, triangle
from mgeo_attitude.geometry.vector import Vec3
from mgeo_attitude.sensors.suite import Suite


class Places(NamedTuple):
    """First slot of each kind of value that the step backward has beside those of `Layout`.

    Derivatives by the covariance (a full matrix), the attitude, and what a maneuver writes to a
    lane, in its order: these are summed up. Then the covariance and attitude before the step, the
    covariance after each update, and room for what loops hand on. The `end` is their number.
    """

    covariance: int
    attitude: int
    maneuver: int
    before: int
    after: int
    gain: int
    product: int
    seen: int
    end: int


@cache
def places(suite: Suite, gated: tuple[bool, ...]) -> Places:
    """Those of the values that a step backward of a suite has."""
    n, m = suite.n_states, suite.n_kinematic
    first = layout(suite, gated).constants + len(instrument_constants(suite, 1.0)) + n
    maneuver = 9 + len(transition_pattern(suite)) + slots_of(m)
    kept = slots_of(n) + 9, len(suite.sensors) * slots_of(n)
    return Places(*accumulate([first, n * n, 9, maneuver, *kept, 3 * n, 3 * n, 3 * n]))


def adjoint_source(suite: Suite, gated: tuple[bool, ...], lanes: int) -> str:
    """Source of a suite's module, with the compiled function ``back(W)``.

    It is given the covariance and the attitude before a step, and does that once more.
    """
    back, forward = _Back(suite, gated), step_parts(suite, gated)
    order, own = ["keep", "propagate"], range(len(suite.sensors))
    order += [name for index in own for name in (f"update_{index}", f"keep_{index}")]
    order[-1:] = [*(f"back_{index}" for index in reversed(own)), "back"]
    texts = forward | {name: code.text for name, code in back.parts.items()}
    functions = "\n\n".join(
        f'{name}_ = lanewise("""\n{texts[name]}\n""", {lanes})' for name in order
    )
    calls = "\n".join(f"    {name}_(W)" for name in order)
    return f'''"""Step backward of {suite.n_states} states. Generated; do not edit."""

from numba import cfunc

from {__package__}.lanewise import lanewise

{functions}

@cfunc("{SIGNATURE}", cache=True)
def back(W):
{calls}
'''


class _Back(Step):
    """The parts of a step backward."""

    def __init__(self, suite: Suite, gated: tuple[bool, ...]) -> None:
        super().__init__(suite, gated)
        self.n, self.own = suite.n_states, places(suite, gated)
        self._keep("keep", self.own.before, slots_of(self.n) + 9)
        self._propagate()
        for index in range(len(suite.sensors)):  # in the order of their constants
            after = self.own.after + index * slots_of(self.n)
            self._keep(f"keep_{index}", after, slots_of(self.n))
            self._update(index, 0 if index == len(suite.sensors) - 1 else after)

    def _keep(self, name: str, to: int, count: int) -> None:
        code = self.part(name)
        with code.loop(0, count) as k:
            code.store(f"{k} + {to}", code.slot(str(k)))

    def _by_covariance(self, code: Code, i: int | Index, j: int | Index) -> Symbol:
        """An entry of Λ, of which one index at least is known."""
        first = self.own.covariance
        if isinstance(i, int):
            return code.slot(f"{j} + {first + self.n * i}")
        return code.slot(f"{self.n} * ({i}) + {first + int(str(j))}")

    def _three(self, code: Code, first: int, state: int | Index, m: int) -> list[Symbol]:
        """The m numbers of a state, of at most three, in the slots from `first` on."""
        return [code.slot(f"3 * ({state}) + {first + r}") for r in range(m)]

    def _propagate(self) -> None:
        code, own, n = self.part("back"), self.own, self.n
        pattern, P = transition_pattern(self.suite), Triangle(code, first=own.before)
        F: dict[tuple[int, int], Any] = {**self.transition(code)[0]}
        of_F = own.maneuver + 9
        for k, (i, j) in enumerate(zip(*triangle(self.suite.n_kinematic), strict=True)):
            each = self._by_covariance(code, int(i), int(j)) * (1.0 if i == j else 2.0)
            code.add(of_F + len(pattern) + k, each)
        rows, columns = {i for i, _ in F}, sorted({j for _, j in F})
        F |= {(j, j): 1.0 for j in columns if j not in rows}
        with code.loop(0, n) as state:  # Λ F
            self._mix(code, F, columns, [self._by_covariance(code, state, j) for j in range(n)])
        for k, (row, column) in enumerate(pattern):
            if row < 3:  # rates turn the attitude alone
                by = sum(self._by_covariance(code, row, j) * P[j, column] for j in range(n))
                code.add(of_F + k, 2.0 * by)
        with code.loop(0, n) as state:  # Fᵀ (Λ F)
            self._mix(code, F, columns, [self._by_covariance(code, i, state) for i in range(n)])
        C = code.slots(own.before + slots_of(n), 9)
        turn = code.slots(self.at.rotation, 9)
        by_C = [code.line(each.name) for each in code.slots(own.attitude, 9)]
        for i, k in product(range(3), range(3)):
            code.add(
                own.maneuver + 3 * i + k, sum(by_C[3 * i + j] * C[3 * k + j] for j in range(3))
            )
            value = sum(turn[3 * j + i] * by_C[3 * j + k] for j in range(3))
            code.store(own.attitude + 3 * i + k, value)

    @staticmethod
    def _mix(code: Code, F: Sparse, columns: list[int], row: list[Symbol]) -> None:
        """A row times F, in place."""
        values = [sum(row[i] * F[i, j] for i in range(len(row)) if (i, j) in F) for j in columns]
        for j, value in zip(columns, values, strict=True):
            code.assign(row[j], value)

    def _update(self, index: int, after: int) -> None:
        code, own, n = self.part(f"back_{index}"), self.own, self.n
        P, to_body = Triangle(code, first=after), partial(self.to_body, code)
        vectors = self.vectors(code, index, to_body)
        measure = self.measure(code, index, vectors, to_body)
        variances, gate = self.noise(code, index, vectors[0])
        weights = [gate * (1.0 / variance) for variance in variances]
        m, support = len(variances), looked_at(n, measure)
        H = {j: measure([1.0 if i == j else 0.0 for i in range(n)]) for j in support}
        turns = [j for j in support if any(isinstance(entry, Symbol) for entry in H[j])]
        project(P, n, measure, support, own.gain)
        with code.loop(0, n) as state:  # K
            for slot, weight in zip(self._three(code, own.gain, state, m), weights, strict=True):
                code.assign(slot, slot * weight)
        K, Y, M = (
            [self._three(code, first, i, m) for i in range(n)]
            for first in (own.gain, own.product, own.seen)
        )
        with code.loop(0, n) as state:  # Y = Λ K
            row = [code.line(self._by_covariance(code, state, j).name) for j in range(n)]
            for r, slot in enumerate(self._three(code, own.product, state, m)):
                code.assign(slot, sum(row[j] * K[j][r] for j in range(n)))
        for block in sorted({j - j % 3 for j in turns}):  # Mᵀ = Kᵀ Λ P⁺, where C changes H
            with code.loop(block, block + 3) as state:
                for r, slot in enumerate(self._three(code, own.seen, state, m)):
                    code.assign(slot, sum(Y[i][r] * P[i, state] for i in range(n)))
        self._by_attitude(code, index, {j: M[j] for j in turns})
        # Aᵀ Λ A = Λ - V H - (V H)ᵀ, V = Y - Hᵀ (Kᵀ Y) / 2, in the place of Y
        KY = [[sum(K[i][r] * Y[i][s] for i in range(n)) for s in range(m)] for r in range(m)]
        for j, s in product(support, range(m)):
            half = sum(0.5 * (KY[r][s] * H[j][r]) for r in range(m))
            code.assign(Y[j][s], Y[j][s] - half)
        for block in sorted({j - j % 3 for j in support}):
            with code.loop(0, n) as state:
                V = [code.line(e.name) for e in self._three(code, own.product, state, m)]
                for j in (j for j in support if block <= j < block + 3):
                    value = sum(V[r] * H[j][r] for r in range(m))
                    for i, k in (state, j), (j, state):
                        slot = self._by_covariance(code, i, k)
                        code.assign(slot, slot - value)

    def _by_attitude(self, code: Code, index: int, M: dict[int, list[Symbol]]) -> None:
        """Add the derivative by C, of the states of which C changes H."""

        def seen(to_body: ToBody) -> Any:
            """The sum of the products of M and H."""
            measure = self.measure(code, index, self.vectors(code, index, to_body), to_body)
            m = len(self.suite.sensors[index].noise())
            columns = [[M[j][r] if j in M else 0.0 for j in range(self.n)] for r in range(m)]
            return sum(measure(column)[r] for r, column in enumerate(columns))

        def unit(i: int, k: int, vector: Iterable[Any]) -> Vec3:
            only = tuple(vector)[k]
            return Vec3(*(only if axis == i else 0.0 for axis in range(3)))

        constant = seen(lambda vector: Vec3(0.0, 0.0, 0.0))
        for i, k in product(range(3), range(3)):
            by = constant - seen(partial(unit, i, k))
            code.add(self.own.attitude + 3 * i + k, 2.0 * by)
