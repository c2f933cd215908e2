"""Time history of the filter for one design: 1-sigmas, attitudes and measurement models."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.motion import Motion


@dataclass(frozen=True)
class FilterHistory:
    """Time history of a filter run: 1-sigmas, covariance trace and attitude at each sample.

    The history ends when the run converges.

    Attributes
    ----------
    times : array, shape (n,)
        Time since the start [s].
    trace : array, shape (n,)
        Weighted trace of the covariance.
    sigma : array, shape (n, n_states)
        1-sigma of every state.
    attitude : array, shape (n, 3, 3)
        GCRS-to-body matrices.
    covariance : array, shape (n_states, n_states)
        Covariance matrix at the end.
    blocks : tuple of str
        Names of the 3-vectors of the state.
    converged : bool
        Whether the run converged before the scenario's end.

    Examples
    --------
    >>> from mgeo_attitude import FilterModel, Scenario, run_filter
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> history = run_filter(FilterModel.from_scenario(Scenario.paper()), design)
    >>> history.converged, float(history.times[-1]), history.blocks[:2]
    (True, 2337.0, ('attitude', 'gyro.bias'))
    """

    times: Floats
    trace: Floats
    sigma: Floats
    attitude: Floats
    covariance: Floats
    blocks: tuple[str, ...]
    converged: bool

    @property
    def t_end(self) -> float:
        """End time of the filter run [s], which is the objective ``t_end``."""
        return float(self.times[-1])


def run_filter(model: FilterModel, design: ArrayLike) -> FilterHistory:
    """Run the compiled covariance filter for one design, and return its time history.

    The filter consists of equations (2) to (4) of docs/explanation/models-and-filter.md.
    `run_reference_filter` computes the same history with filterpy in about a hundred times the
    time.

    Parameters
    ----------
    model : FilterModel
    design : array_like, shape (4 m,)
        Rates [deg/s] and duration [s] of each maneuver in turn.

    Raises
    ------
    ValueError
        If the covariance loses positive definiteness.

    Examples
    --------
    >>> from mgeo_attitude import FilterModel, Scenario, run_filter
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> history = run_filter(FilterModel.from_scenario(Scenario.paper()), design)
    >>> bool(history.trace[-1] < history.trace[0])
    True
    """
    result = evaluate(model, np.atleast_2d(np.asarray(design, dtype=float)), 1, True, True)
    t_end = result.t_end[0]
    if np.isnan(t_end):
        raise ValueError(
            f"the covariance of design {np.ravel(design).tolist()} loses positive definiteness"
        )
    n = round(t_end / model.step) + 1
    variances = result.variances[0, :n]
    return FilterHistory(
        times=model.times[:n],
        trace=variances @ model.weights,
        sigma=np.sqrt(variances),
        attitude=Motion.from_design(model, design, n - 1).attitude,
        covariance=result.covariance[0],
        blocks=model.suite.blocks,
        converged=bool(t_end < model.duration),
    )


def can_measure(model: FilterModel, index: int, attitude: Floats, rates: Floats) -> Bools:
    """Return a mask of the samples of an attitude history at which a sensor can measure.

    A sensor measures if it is available, if its field-of-view conditions are satisfied, and if the
    body rate is at most the sensor's maximum.

    Parameters
    ----------
    model : FilterModel
    index : int
        Index of the sensor in the suite.
    attitude : array, shape (k + 1, 3, 3)
        GCRS-to-body matrices.
    rates : array, shape (k, 3)
        Body rate in each step [rad/s].

    Returns
    -------
    array of bool, shape (k + 1,)
    """
    samples = slice(len(attitude))
    sensor, mask = model.suite.sensors[index], model.available[samples, index].copy()
    for cone in sensor.list_visibility_cones():
        vectors, radius = model.references[samples, index], np.zeros(len(attitude))
        if cone.direction:
            vectors, radius = model.select_direction(cone.direction, samples)
        cosine = np.einsum("kij,kj->ki", attitude, vectors) @ cone.axis
        mask &= (cosine >= np.cos(cone.half_angle + radius)) == cone.keep_in
    mask[1:] &= np.einsum("ki,ki->k", rates, rates) <= sensor.get_max_rate() ** 2
    return mask


def build_measurement_model(
    model: FilterModel, attitude: Floats, rates: Floats
) -> tuple[Floats, Floats, Bools]:
    """Return measurement matrices, noise variances and a mask of available measurements.

    They cover all sensors along an attitude history.

    Parameters
    ----------
    model : FilterModel
    attitude, rates : arrays
        See `can_measure`.

    Returns
    -------
    H : array, shape (n_steps + 1, m, n_states)
        Measurement matrices.
    R : array, shape (m,)
        Noise variances.
    is_measured : array of bool, shape (n_steps + 1, m)
        Whether each row is measured at each sample.
    """
    H: list[Floats] = []
    R: list[float] = []
    is_measured: list[Bools] = []
    # A sample has the rate of the step before it.
    sample_rates = np.vstack([rates[:1], rates])
    for index, sensor in enumerate(model.suite.sensors):
        v, *auxiliary_vectors = (
            np.einsum("kij,kj->ki", attitude, model.references[:, row])
            for row in model.suite.list_vector_indices(index)
        )
        deviations = [*model.sensitivity_factors[:, model.suite.find_sensitivity_columns(sensor)].T]
        H.append(
            model.suite.measurement_matrix(
                sensor, v, attitude, auxiliary_vectors, sample_rates, deviations
            )
        )
        R.extend(sigma**2 for sigma in sensor.noise_sigmas())
        is_measured.extend(
            [can_measure(model, index, attitude, rates)] * len(sensor.noise_sigmas())
        )
    return np.concatenate(H, axis=1), np.array(R), np.stack(is_measured, axis=1)
