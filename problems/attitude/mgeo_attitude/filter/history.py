"""Sample-by-sample filter results of one design: 1-sigmas, attitudes and measurements."""

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
    """Results of a filter run from the start to convergence, at n samples.

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
        Covariance at the end.
    blocks : tuple of str
        Names of the 3-vectors of the state.
    converged : bool
        False if the run ended at the scenario's duration.

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
        """End of the run [s], the first objective of equation (5)."""
        return float(self.times[-1])


def run_filter(model: FilterModel, design: ArrayLike) -> FilterHistory:
    """Run the compiled filter of equations (2) to (4) over one design and return all samples.

    `run_reference_filter` computes the same history with filterpy and takes about a hundred times as long.

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
        raise ValueError(f"the covariance of design {np.ravel(design).tolist()} loses positivity")
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
    """Return whether a sensor can measure at each of the first k + 1 samples.

    A measurement requires an available sensor, satisfied field-of-view conditions, and a body rate
    of at most the sensor's maximum.

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
    for view in sensor.list_visibility_cones():
        looked_at, radius = model.references[samples, index], np.zeros(len(attitude))
        if view.direction:
            looked_at, radius = model.select_direction(view.direction, samples)
        cosine = np.einsum("kij,kj->ki", attitude, looked_at) @ view.axis
        mask &= (cosine >= np.cos(view.half_angle + radius)) == view.keep_in
    mask[1:] &= np.einsum("ki,ki->k", rates, rates) <= sensor.max_rate() ** 2
    return mask


def build_measurement_model(
    model: FilterModel, attitude: Floats, rates: Floats
) -> tuple[Floats, Floats, Bools]:
    """Return the measurement matrices, noise variances and availability of all m measurement rows.

    Parameters
    ----------
    model : FilterModel
    attitude, rates : arrays
        See `can_measure`.

    Returns
    -------
    H : array, shape (n_steps + 1, m, n_states)
    R : array, shape (m,)
        Noise variances.
    seen : array of bool, shape (n_steps + 1, m)
        Whether each row is measured at each sample.
    """
    H: list[Floats] = []
    R: list[float] = []
    seen: list[Bools] = []
    before = np.vstack([rates[:1], rates])  # A sample has the rate of the step before it.
    for index, sensor in enumerate(model.suite.sensors):
        v, *gradient = (
            np.einsum("kij,kj->ki", attitude, model.references[:, row])
            for row in model.suite.list_vector_indices(index)
        )
        follows = [*model.sensitivity_factors[:, model.suite.find_sensitivity_columns(sensor)].T]
        H.append(model.suite.measurement_matrix(sensor, v, attitude, gradient, before, follows))
        R.extend(sigma**2 for sigma in sensor.noise_sigmas())
        seen.extend([can_measure(model, index, attitude, rates)] * len(sensor.noise_sigmas()))
    return np.concatenate(H, axis=1), np.array(R), np.stack(seen, axis=1)
