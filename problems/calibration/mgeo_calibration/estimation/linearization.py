"""Process and measurement equations of a batch, linearized about a trajectory.

The smoother and the score tests solve these equations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.sensors.measurements import unstack_measurement

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.innovation import (
    ZERO_RATE,
    Estimate,
    compute_innovation,
    compute_jacobian,
)
from mgeo_calibration.estimation.kinematics import (
    ProcessEquations,
    compute_rates_and_rotations,
    linearize_process,
)
from mgeo_calibration.estimation.taylor import (
    ConstantPolynomial,
    LinearPolynomial,
    TaylorPolynomial,
)
from mgeo_calibration.estimation.trajectory import Partition, Trajectory, split_into_spans


@dataclass(frozen=True, eq=False)
class SensorEquations:
    """Measurement equations of one sensor, linearized about a trajectory.

    Each reading satisfies z - H e ~ N(0, diag(noise)²) for the errors e of the states.

    Attributes
    ----------
    samples : array of int, shape (m,)
        Sample index of each reading.
    z : array, shape (m, k)
        Innovations of the k components, at most three.
    states : array of int, shape (p,)
        States of the columns of H.
    H : array, shape (m, k, p)
        Jacobian with respect to the errors of these states.
    noise : array, shape (k,)
        1-sigma of each component.
    """

    samples: Ints
    z: Floats
    states: Ints
    H: Floats
    noise: Floats


@dataclass(frozen=True, eq=False)
class MeasurementEquations:
    """Measurement equations of all s sensors, linearized about a trajectory and padded to equal
    size.

    Readings with fewer than three components are padded with components that are always zero.

    Attributes
    ----------
    has_reading : array of bool, shape (s, N)
        True where a sensor has a reading.
    z : array, shape (s, N, 3)
        Innovations.
    H : array, shape (s, N, 3, p)
        Jacobians with respect to the stochastic states, then to the constant states.
    noise : array, shape (s, 3)
        1-sigma of each component.
    n_components : array of int, shape (s,)
        Number of components of each sensor.
    n_columns : array of int, shape (s, 2)
        Number of columns of H for the stochastic states and for the constant states.
    columns : array of int, shape (s, p)
        Index of each column of H among the stochastic or the constant states.
    """

    has_reading: Bools
    z: Floats
    H: Floats
    noise: Floats
    n_components: Ints
    n_columns: Ints
    columns: Ints

    @property
    def arrays(self) -> tuple[Floats, Floats, Floats, Ints, Ints]:
        """Arrays z, H, noise, n_columns and columns in the order that the compiled functions
        expect.
        """
        return self.z, self.H, self.noise, self.n_columns, self.columns

    @property
    def n_leading(self) -> int:
        """Smallest n, at least 3, such that only the first n stochastic states affect readings."""
        columns_and_counts = zip(self.columns, self.n_columns, strict=True)
        return max(3, *(int(row[:n].max(initial=-1)) + 1 for row, (n, _) in columns_and_counts))


def linearize_measurements(
    batch: Batch, trajectory: Trajectory, partition: Partition
) -> MeasurementEquations:
    """Linearize the measurement equations of all sensors about a trajectory.

    Parameters
    ----------
    batch : Batch
    trajectory : Trajectory
        Trajectory to linearize about, at all samples of the batch.
    partition : Partition
        Stochastic and constant states.

    Returns
    -------
    MeasurementEquations
    """
    equations = [
        linearize_sensor(batch, index, trajectory) for index in range(len(batch.suite.sensors))
    ]
    s, N, p = len(equations), len(batch.times), max(len(sensor.states) for sensor in equations)
    result = MeasurementEquations(
        has_reading=np.zeros((s, N), dtype=bool),
        z=np.zeros((s, N, 3)),
        H=np.zeros((s, N, 3, p)),
        noise=batch.noise,
        n_components=np.array([len(sensor.noise) for sensor in equations]),
        n_columns=np.zeros((s, 2), dtype=np.int64),
        columns=np.zeros((s, p), dtype=np.int64),
    )
    for index, sensor in enumerate(equations):
        selections = [
            np.flatnonzero(np.isin(sensor.states, states))
            for states in (partition.stochastic, partition.constant)
        ]
        order, n = np.concatenate(selections), len(sensor.states)
        result.has_reading[index, sensor.samples] = True
        result.z[index, sensor.samples, : len(sensor.noise)] = sensor.z
        result.H[index, sensor.samples, : len(sensor.noise), :n] = sensor.H[:, :, order]
        result.n_columns[index] = [len(selection) for selection in selections]
        result.columns[index, :n] = np.concatenate(
            [
                np.searchsorted(states, sensor.states[selection])
                for states, selection in zip(
                    (partition.stochastic, partition.constant), selections, strict=True
                )
            ]
        )
    return result


def linearize_sensor(batch: Batch, index: int, trajectory: Trajectory) -> SensorEquations:
    """Linearize the measurement equations of one sensor about a trajectory.

    The body rate for a measurement latency is the rate of the step that ends at the sample.

    If the satellite is assumed to hold an attitude, the sensitivities to all states except
    rotations are evaluated at the held attitude, in the directions in which an attitude error moves
    the readings. The estimated attitude contains the pointing error that is in the readings, and a
    scale factor would grow to explain this error (instrumental variables; W. A. Fuller, Measurement
    Error Models, Wiley 1987).

    Parameters
    ----------
    batch : Batch
    index : int
        Index of the sensor in the suite.
    trajectory : Trajectory
        Trajectory to linearize about.

    Returns
    -------
    SensorEquations
    """
    suite, sensor = batch.suite, batch.suite.sensors[index]
    samples = np.flatnonzero(np.isfinite(batch.readings[index][:, 0, 0]))
    m = len(sensor.noise_sigmas())
    noise = batch.noise[index, :m]
    if not len(samples):
        return SensorEquations(samples, np.zeros((0, m)), samples, np.zeros((0, m, 0)), noise)
    z, states, H = _linearize_samples(batch, index, trajectory, samples)
    if batch.pointing is not None:
        held_trajectory = Trajectory(batch.pointing.attitude, trajectory.states)
        _, _, H_held = _linearize_samples(batch, index, held_trajectory, samples)
        H_attitude = H[:, :, states < 3]
        change = H_attitude @ np.linalg.pinv(H_attitude, rcond=1e-6) @ (H_held - H)
        rotations = np.add.outer(suite.rotation_indices, range(3))
        H = np.where(np.isin(states, rotations), H, H + change)
    return SensorEquations(samples, z, states, H, noise)


def _linearize_samples(
    batch: Batch, index: int, trajectory: Trajectory, samples: Ints
) -> tuple[Floats, Ints, Floats]:
    """Return the innovations, the state indices and the Jacobian of one sensor at the given
    samples.
    """
    r = _compute_innovation(batch, index, trajectory, samples, LinearPolynomial)
    states, H = compute_jacobian(r)
    H = np.moveaxis(np.broadcast_to(H, (*H.shape[:2], len(samples))), -1, 0)
    return r.value.T, states, H


def _compute_innovation(
    batch: Batch, index: int, trajectory: Trajectory, samples: Ints, kind: type[TaylorPolynomial]
) -> TaylorPolynomial:
    suite, sensor = batch.suite, batch.suite.sensors[index]
    rate = ZERO_RATE  # Only a sensor with a measurement latency depends on the body rate.
    if "latency" in suite.get_first_indices(sensor):
        rates, _ = compute_rates_and_rotations(batch, trajectory.states)
        rate = rates[np.maximum(samples - 1, 0)]
    attitude = np.moveaxis(trajectory.attitude[samples], 0, -1)
    vectors = batch.vectors[samples]
    return compute_innovation(
        suite,
        index,
        unstack_measurement(batch.readings[index][samples]),
        vectors[:, index],
        Estimate.from_states(suite, attitude, trajectory.states[samples].T, np.zeros(0)),
        auxiliary_vectors=[
            vectors[:, k] for k in range(vectors.shape[1])[suite.find_auxiliary_rows(index)]
        ],
        kind=kind,
        rate=rate,
        channel_values=batch.select_channel_values(sensor, samples),
    )


def compute_sensor_innovations(
    batch: Batch, index: int, trajectory: Trajectory
) -> tuple[Ints, Floats]:
    """Return the sample indices and the innovations of all readings of one sensor.

    Parameters
    ----------
    batch : Batch
    index : int
        Index of the sensor in the suite.
    trajectory : Trajectory
        Trajectory that predicts the readings.

    Returns
    -------
    samples : array of int, shape (n,)
        Indices of the samples.
    innovations : array, shape (n, k)
        Reading minus prediction, in the unit of the sensor's noise.
    """
    samples = np.flatnonzero(np.isfinite(batch.readings[index][:, 0, 0]))
    r = _compute_innovation(batch, index, trajectory, samples, ConstantPolynomial)
    return samples, r.value.T


def compute_innovations(batch: Batch, index: int, trajectory: Trajectory) -> Floats:
    """Return the innovations of one sensor at all samples, as an array of shape (N, k). Samples
    without a reading are NaN.

    Parameters
    ----------
    batch : Batch
    index : int
        Index of the sensor in the suite.
    trajectory : Trajectory
        Trajectory that predicts the readings.
    """
    result = np.full((len(batch.times), len(batch.suite.sensors[index].noise_sigmas())), np.nan)
    for low, high, first in split_into_spans(len(result)):
        samples, z = compute_sensor_innovations(
            batch.select_samples(low, high), index, trajectory.select_samples(low, high)
        )
        new = samples >= first
        result[low + samples[new]] = z[new]
    return result


@dataclass(frozen=True, eq=False)
class Equations:
    """Process and measurement equations of consecutive samples, linearized about a trajectory.

    Attributes
    ----------
    low, high : int
        Index of the first sample, and of the sample after the last.
    batch : Batch
        Batch of these samples.
    trajectory : Trajectory
        Trajectory at these samples.
    partition : Partition
        Stochastic and constant states.
    process : ProcessEquations
    measurements : MeasurementEquations
    """

    low: int
    high: int
    batch: Batch
    trajectory: Trajectory
    partition: Partition
    process: ProcessEquations
    measurements: MeasurementEquations


def linearize_equations(
    batch: Batch,
    trajectory: Trajectory,
    partition: Partition,
    constant_factors: Floats,
    low: int,
    high: int,
) -> Equations:
    """Linearize the process and measurement equations of the samples `low` to `high` - 1 about a
    trajectory.

    Parameters
    ----------
    batch : Batch
        Batch of all samples.
    trajectory : Trajectory
        Trajectory to linearize about, at all samples.
    partition : Partition
        Stochastic and constant states.
    constant_factors : array, shape (N, c)
        Result of `kinematics.compute_constant_factors` at all samples.
    low, high : int
        Index of the first sample, and of the sample after the last.

    Returns
    -------
    Equations
    """
    span_batch, span_trajectory = (
        batch.select_samples(low, high),
        trajectory.select_samples(low, high),
    )
    process = linearize_process(span_batch, span_trajectory, partition, constant_factors[low:high])
    return Equations(
        low,
        high,
        span_batch,
        span_trajectory,
        partition,
        process,
        linearize_measurements(span_batch, span_trajectory, partition),
    )
