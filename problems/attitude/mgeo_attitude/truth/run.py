"""Runs of truth and estimator over one plan: tables once, then any number of draws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial
from types import ModuleType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..filter import discretization
from ..filter.discretization import discretize
from ..filter.kernel import load_module
from ..filter.model import FilterModel
from ..filter.reference import attitudes
from ..filter.suite import Suite
from ..filter.timeline import flown
from ..scenario import KeepOut
from . import algebra
from .codegen import module_source
from .draws import Draws, at_rest
from .estimator import Estimator

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_SEES_EVERYTHING = -2.0  # a cosine that no direction falls below


@dataclass(frozen=True)
class Record:
    """One run at n samples.

    Attributes
    ----------
    errors : array, shape (n, n_states)
        Truth less estimate: a difference or, for attitude and misalignments, the vector of the
        rotation that remains.
    variances : array, shape (n, n_states)
        What the estimator claims.
    nees : array, shape (n,)
        Normalized estimation error squared.
    nis : array, shape (n, n_sensors)
        Sum of the normalized innovations squared since the sample before.
    updates : array of int, shape (n, n_sensors)
        Number of these innovations.
    inside : array of int, shape (2, n_cones)
        Samples at which the Sun was inside each keep-out cone: with the satellite steered by the
        estimate, and flown open loop. See `MonteCarlo.keep_outs`.
    """

    errors: Floats
    variances: Floats
    nees: Floats
    nis: Floats
    updates: Ints
    inside: Ints


@dataclass(frozen=True)
class Flight:
    """One plan, ready to be simulated until the last of `records`.

    Attributes
    ----------
    model : FilterModel
    design : array, shape (4 m,)
    records : array of int
        Steps to record, increasing.
    truth : FilterModel, optional
        What is true, if it is not the `model` that the estimator believes in: what sensors look at
        and when they see it, how the gyro's states go on, what sensors and gyro report.
    keep_outs : tuple of KeepOut
        Cones to watch.
    n_watched : int
        Samples from the start at which to watch them.
    """

    model: FilterModel
    design: ArrayLike
    records: Ints
    truth: FilterModel | None = None
    keep_outs: tuple[KeepOut, ...] = ()
    n_watched: int = 0

    @property
    def n_steps(self) -> int:
        return int(self.records[-1])

    def run(self, draws: Draws, estimator: Estimator) -> Record:
        """Simulate one run; see `driver.run`."""
        suite, n = self.model.suite, len(self.records)
        record = Record(
            errors=np.empty((n, suite.n_states)),
            variances=np.empty((n, suite.n_states)),
            nees=np.zeros(n),
            nis=np.zeros((n, len(suite.sensors))),
            updates=np.zeros((n, len(suite.sensors)), dtype=np.int64),
            inside=np.zeros((2, len(self.keep_outs)), dtype=np.int64),
        )
        simulator(suite, self._reality.suite).run(
            *self._tables,
            draws.errors,
            draws.gyro_noise,
            draws.noise,
            estimator.options(),
            self.records,
            record.errors,
            record.variances,
            record.nees,
            record.nis,
            record.updates,
            np.ascontiguousarray(self._reality.sun),
            _cones(self.keep_outs),
            self.n_watched if self.keep_outs else 0,
            record.inside,
        )
        return record

    @property
    def _reality(self) -> FilterModel:
        return self.model if self.truth is None else self.truth

    @cached_property
    def _tables(self) -> tuple[object, ...]:
        model, truth, suite, n = self.model, self._reality, self.model.suite, self.n_steps
        plan = flown(self.design, n * model.step, model.step, model.agility)
        starts = np.rint(plan.times[:-1] / model.step).astype(np.int64)
        density = suite.diffusion()
        steps = [discretize(suite.dynamics_matrix(w), density, model.step) for w in plan.rates]
        return (
            np.ascontiguousarray(plan.rates),
            np.searchsorted(starts, np.arange(n), side="right") - 1,
            np.array([F for F, _ in steps]),
            np.array([Q for _, Q in steps]),
            attitudes(plan.rates, starts, n, model.step),
            np.ascontiguousarray(model.references[: n + 1]),
            np.ascontiguousarray(truth.references[: n + 1]),
            np.ascontiguousarray(truth.available[: n + 1]),
            _views(truth.suite),
            np.array([np.square(sensor.noise()) for sensor in suite.sensors]),
            model.step,
            at_rest(model)[0],
            at_rest(truth)[0],
            model.initial_sigma,
        )


@cache
def simulator(suite: Suite, truth: Suite) -> ModuleType:
    """The compiled module of what is believed and what reports; its ``run`` is `driver.run`."""
    source_of = partial(module_source, suite, truth)
    return load_module("simulator", source_of, (algebra, discretization))


def _cones(keep_outs: Sequence[KeepOut]) -> Floats:
    """Axis and cosine of the half-angle of every cone."""
    rows = [[*cone.axis(), np.cos(np.radians(cone.half_angle_deg))] for cone in keep_outs]
    return np.array(rows).reshape(-1, 4)


def _views(suite: Suite) -> Floats:
    """Boresight and cosine of the half-angle of every sensor's field of view."""
    rows = []
    for sensor in suite.sensors:
        boresight, half_angle = sensor.field_of_view() or ((0.0, 0.0, 0.0), None)
        cosine = _SEES_EVERYTHING if half_angle is None else np.cos(half_angle)
        rows.append([*boresight, cosine])
    return np.array(rows)
