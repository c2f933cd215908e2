"""Estimates held against the truth: what a simulation records of runs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.estimation.estimate import Estimate
from mgeo_attitude.estimation.filter import ErrorStateFilter, Estimator
from mgeo_attitude.estimation.monte_carlo import Record
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.flight import Flight
from mgeo_attitude.rotation import multiply
from mgeo_attitude.scenario import KeepOut


def record(
    model: FilterModel,
    flights: Sequence[Flight],
    estimator: Estimator,
    samples: Ints,
    cones: Sequence[KeepOut],
    sun: Floats,
) -> Record:
    """Estimate from the readings of flights of one plan, and compare with their truth.

    Parameters
    ----------
    model : FilterModel
        What the estimator believes.
    samples : array of int
        To record, increasing; nothing is estimated after the last.
    cones : sequence of KeepOut
        To watch at the first n samples.
    sun : array, shape (n, 3)
        Direction to the Sun where it shines, else zero, GCRS.
    """
    n_runs, m, suite, motion = len(flights), len(samples), model.suite, flights[0].motion
    start, states, gyro = (
        np.stack([getattr(flight, name) for flight in flights], axis=-1)
        for name in ("start", "errors", "gyro")
    )
    found = Record(
        errors=np.empty((n_runs, m, suite.n_states)),
        sigma=np.empty((n_runs, m, suite.n_states)),
        nees=np.empty((n_runs, m)),
        nis=np.zeros((n_runs, m, len(suite.sensors))),
        updates=np.zeros((n_runs, m, len(suite.sensors)), dtype=np.int64),
        inside=np.zeros((n_runs, 2, len(cones))),
    )
    estimates = ErrorStateFilter(suite, estimator).run(
        Estimate.at_start(suite, model.initial_sigma, n_runs),
        [flight.readings for flight in flights],
        motion.rates,
        model.references,
    )
    d, row = 3 + gyro.shape[1], 0
    for k, (before, after, nis) in enumerate(estimates):
        attitude = multiply(motion.attitude[k][..., None], start)
        if k < len(sun):
            found.inside[:] += _inside(cones, sun[k], motion.attitude[k], attitude, before)
        seen = ~np.isnan(nis.T)
        found.nis[:, row] += np.where(seen, nis.T, 0.0)
        found.updates[:, row] += seen
        if k == samples[row]:
            states[3:d] = gyro[k]
            e, P = after.error(attitude, states).T, after.covariance
            found.errors[:, row], found.sigma[:, row] = e, np.sqrt(np.einsum("iir->ri", P))
            solved = np.linalg.solve(P.transpose(2, 0, 1), e[..., None])[..., 0]
            found.nees[:, row] = (e * solved).sum(axis=1)
            row += 1
            if row == m:
                break
    found.inside[:] /= max(len(sun), 1)
    return found


def _inside(
    cones: Sequence[KeepOut], sun: Floats, planned: Floats, true: Floats, before: Estimate
) -> Bools:
    """Whether the Sun is inside, steered and open loop, shape (r, 2, n_cones).

    `before` is the estimate before the measurements of the sample.
    """
    # a controller on the estimate would have made it the plan's
    steered = np.einsum("ijr,j->ir", before.rotations[:, :, 0], planned @ sun)
    directions = np.stack([steered, np.broadcast_to(sun[:, None], steered.shape)])
    axes = np.array([cone.axis() for cone in cones])
    cosines = np.cos(np.radians([cone.half_angle_deg for cone in cones]))
    inside: Bools = np.einsum("ci,ijr,wjr->rwc", axes, true, directions) > cosines
    return inside
