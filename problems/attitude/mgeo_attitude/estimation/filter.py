"""The error-state filter: what is estimated, of many runs at once, from readings alone.

Runs are the last axis of all arrays but those of readings. With some hundred beside each other
NumPy's loops over them take little longer than compiled code, and the result of a run depends on
nothing but its own numbers.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from mgeo_attitude.filter.suite import Suite
from mgeo_attitude.flight.readings import Readings, as_reported
from mgeo_attitude.rotation import exponential, multiply, vector
from mgeo_attitude.estimation.estimate import Estimate, reset
from mgeo_attitude.estimation.estimator import Estimator
from mgeo_attitude.estimation.innovation import expand, second_moments
from mgeo_attitude.estimation.transition import Transition

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class ErrorStateFilter:
    """A filter of a suite, multiplicative in rotations; errors are fed back after each update."""

    suite: Suite
    estimator: Estimator

    @cached_property
    def places(self) -> Ints:
        """States that are rotations, shape (3, k)."""
        places: Ints = np.arange(3)[:, None] + np.array(self.suite.rotations)
        return places

    @cached_property
    def noise(self) -> list[Floats]:
        """Covariance of each sensor's noise, shape (3, 3, 1)."""
        return [np.diag(np.square(s.noise()))[..., None] for s in self.suite.sensors]

    def estimates(
        self, sigma: Floats, readings: Readings, rates: Floats, references: Floats
    ) -> Iterator[tuple[Estimate, Estimate, Floats]]:
        """Estimates at every sample.

        Parameters
        ----------
        sigma : array, shape (n_states,)
            1-sigma of the errors of `Estimate.at_start`.
        rates : array, shape (n, 3)
            Body rate in each step [rad/s] at which the covariance is propagated.
        references : array, shape (n + 1, n_sensors, 3)
            What the sensors look at, GCRS.

        Yields
        ------
        Estimates before and after the measurements of a sample, and the normalized squares of
        their innovations, shape (n_sensors, r), NaN where a sensor reports nothing.
        """
        transition = cache(lambda rate, duration: Transition.of(self.suite, rate, duration))
        reports = [np.isfinite(sensor[:, :, 0, 0]) for sensor in readings.sensors]
        estimate = Estimate.at_start(self.places, sigma, readings.gyro.shape[1])
        for k in range(len(references)):
            if k:
                step = transition(tuple(rates[k - 1].tolist()), float(readings.durations[k - 1]))
                estimate = self.predict(estimate, readings.gyro[k - 1], step)
            before = estimate
            nis = np.full((len(reports), estimate.states.shape[-1]), np.nan)
            for index, sensor in enumerate(readings.sensors):
                if reports[index][k].any():
                    estimate, nis[index] = self.update(
                        estimate, index, sensor[k], references[k, index]
                    )
            yield before, estimate, nis

    def predict(self, estimate: Estimate, reported: Floats, step: Transition) -> Estimate:
        """Over a step in which the gyro reports a mean rate, shape (r, 3), equation (3).

        Attitude follows the gyro, corrected by what is estimated of its errors.
        """
        gyro, d = self.suite.gyro, self.suite.n_dynamic
        x = {state: estimate.states[i : i + 3] for state, i in self.suite.places(gyro).items()}
        for number, state in enumerate((s for s in x if s in gyro.rotations), start=1):
            x[state] = vector(estimate.rotations[:, :, number])
        x["bias"] = step.mean_bias * x["bias"]
        own = SimpleNamespace(**{state: value.T for state, value in x.items()})
        turn = exponential(-step.duration * gyro.corrected(own, reported).T)
        rotations, states = estimate.rotations.copy(), estimate.states.copy()
        rotations[:, :, 0] = multiply(rotations[:, :, 0], turn.swapaxes(0, 1))
        states[3:d] *= step.decay
        F = np.concatenate([turn, np.repeat(step.F, turn.shape[-1], axis=-1)], axis=1)
        P = estimate.covariance.copy()
        rows = multiply(F, P[:d])
        attitude = multiply(rows[:, :d], F.swapaxes(0, 1))
        rows[:, 3:d] *= step.decay
        P[3:d] *= step.decay[:, None]
        P[:, 3:d] *= step.decay
        P[:3], P[:, :3] = rows, rows.swapaxes(0, 1)
        P[:3, :3] = 0.5 * (attitude + attitude.swapaxes(0, 1))
        P[:d, :d] += step.Q
        return Estimate(self.places, rotations, states, P)

    def update(
        self, estimate: Estimate, sensor: int, readings: Floats, reference: Floats
    ) -> tuple[Estimate, Floats]:
        """By the readings of a sensor, equation (4).

        Parameters
        ----------
        sensor : int
            Its number in the suite.
        readings : array, shape (r, k, 3)
            NaN in runs in which it reports nothing; nothing changes there.
        reference : array, shape (3,)
            What it looks at, GCRS; see `Sensor.reference`.

        Returns
        -------
        Estimate, and the normalized innovation squared, shape (r,)
        """
        options, P, seen = self.estimator, estimate.covariance, ~np.isnan(readings[:, 0, 0])
        y = as_reported(np.where(seen[:, None, None], readings, 0.0))
        now, e, nis = estimate, np.zeros(0), np.zeros(0)
        for iteration in range(options.iterations):
            if iteration:
                now = estimate.without(e, P)
            z, H, states, curvature = expand(
                self.suite, sensor, y, reference, now, options.jacobians == "aligned"
            )
            HP = multiply(H, P[states])
            S = multiply(HP[:, states], H.swapaxes(0, 1)) + self.noise[sensor]
            if iteration:
                z = z + (H * e[states]).sum(axis=1)
            if options.second_order:
                mean, covariance = second_moments(curvature, P)
                z, S = z + mean, S + covariance
            G, w = whiten(S, HP, z)
            G *= seen
            e = (G * w[:, None]).sum(axis=0)
            if not iteration:
                nis = np.where(seen, (w * w).sum(axis=0), np.nan)
        columns = G.swapaxes(0, 1).copy()
        P = P - multiply(columns, G)
        if options.reset:
            reset(P, e, self.places)
        return estimate.without(e, P), nis


def whiten(S: Floats, HP: Floats, z: Floats) -> tuple[Floats, Floats]:
    """L⁻¹ H P and L⁻¹ z for S = L Lᵀ, by elimination; S not positive definite gives NaN."""
    rows = np.concatenate([S, HP, z[:, None]], axis=1)
    with np.errstate(invalid="ignore"):
        for i, row in enumerate(rows):
            row /= np.sqrt(row[i])
            for j in range(i + 1, len(rows)):
                rows[j] -= row[j] * row
    return rows[:, len(S) : -1], rows[:, -1]
