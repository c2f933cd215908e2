"""Estimates held against the truth: what a simulation records of runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.flight import Flight
from mgeo_attitude.scenario import KeepOut
from mgeo_attitude.estimation.estimate import Estimate
from mgeo_attitude.estimation.estimator import Estimator
from mgeo_attitude.estimation.filter import ErrorStateFilter

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Record:
    """Of r runs, at m samples.

    Attributes
    ----------
    errors : array, shape (r, m, n_states)
        Truth less estimate: a difference or, for attitude and misalignments, the vector of the
        rotation that remains.
    variances : array, shape (r, m, n_states)
        What the estimator claims.
    nees : array, shape (r, m)
        Normalized estimation error squared.
    nis : array, shape (r, m, n_sensors)
        Sum of the normalized innovations squared since the sample before.
    updates : array of int, shape (r, m, n_sensors)
        Number of these innovations.
    inside : array of int, shape (r, 2, n_cones)
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
class Watch:
    """Keep-out cones to watch, n samples from the start.

    Attributes
    ----------
    cones : sequence of KeepOut
    sun : array, shape (n, 3)
        Direction to the Sun where it shines, else zero, GCRS.
    """

    cones: Sequence[KeepOut]
    sun: Floats

    def inside(self, sample: int, flight: Flight, estimate: Estimate) -> NDArray[np.bool_]:
        """Whether the Sun is inside, steered and open loop, shape (r, 2, n_cones).

        Parameters
        ----------
        estimate : Estimate
            Before the measurements of the sample.
        """
        true, planned, sun = (
            flight.attitude(sample),
            flight.motion.attitude[sample],
            self.sun[sample],
        )
        # a controller on the estimate would have made it the plan's
        steered = np.einsum("ijr,j->ir", estimate.rotations[:, :, 0], planned @ sun)
        directions = np.stack([steered, np.broadcast_to(sun[:, None], steered.shape)])
        axes = np.array([cone.axis() for cone in self.cones])
        cosines = np.cos(np.radians([cone.half_angle_deg for cone in self.cones]))
        inside: NDArray[np.bool_] = np.einsum("ci,ijr,wjr->rwc", axes, true, directions) > cosines
        return inside


def record(
    model: FilterModel,
    flight: Flight,
    estimator: Estimator,
    samples: Ints,
    watch: Watch | None = None,
) -> Record:
    """Estimate from a flight's readings, and compare with its truth.

    Parameters
    ----------
    model : FilterModel
        What the estimator believes.
    samples : array of int
        To record, increasing; nothing is estimated after the last.
    """
    n_runs, m, suite = flight.start.shape[-1], len(samples), model.suite
    found = Record(
        errors=np.empty((n_runs, m, suite.n_states)),
        variances=np.empty((n_runs, m, suite.n_states)),
        nees=np.empty((n_runs, m)),
        nis=np.zeros((n_runs, m, len(suite.sensors))),
        updates=np.zeros((n_runs, m, len(suite.sensors)), dtype=np.int64),
        inside=np.zeros((n_runs, 2, len(watch.cones) if watch else 0), dtype=np.int64),
    )
    estimates = ErrorStateFilter(suite, estimator).estimates(
        model.initial_sigma, flight.readings, flight.motion.rates, model.references
    )
    row = 0
    for k, (before, after, nis) in enumerate(estimates):
        if watch and k < len(watch.sun):
            found.inside[:] += watch.inside(k, flight, before)
        seen = ~np.isnan(nis.T)
        found.nis[:, row] += np.where(seen, nis.T, 0.0)
        found.updates[:, row] += seen
        if k == samples[row]:
            e, P = after.error(flight.attitude(k), flight.states(k)).T, after.covariance
            found.errors[:, row], found.variances[:, row] = e, np.einsum("iir->ri", P)
            solved = np.linalg.solve(P.transpose(2, 0, 1), e[..., None])[..., 0]
            found.nees[:, row] = (e * solved).sum(axis=1)
            row += 1
            if row == m:
                break
    return found
