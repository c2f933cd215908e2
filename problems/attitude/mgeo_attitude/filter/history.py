"""One design sample by sample: what the compiled filter knows, and what its sensors see."""

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
    """A filter run from its start to convergence, n samples.

    Attributes
    ----------
    times : array, shape (n,)
        [s]
    trace : array, shape (n,)
        Weighted trace of the covariance.
    sigma : array, shape (n, n_states)
        1-sigma of every state.
    attitude : array, shape (n, 3, 3)
        GCRS to body.
    covariance : array, shape (n_states, n_states)
        Covariance at the end.
    blocks : tuple of str
        Names of the state's 3-vectors.
    converged : bool
        False where the run ended at the scenario's duration.

    Examples
    --------
    >>> from mgeo_attitude import FilterModel, Scenario, filter_history
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> history = filter_history(FilterModel.from_scenario(Scenario.paper()), design)
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
        """First objective of equation (5) [s]."""
        return float(self.times[-1])


def filter_history(model: FilterModel, design: ArrayLike) -> FilterHistory:
    """The filter of equations (2) to (4) over one design, shape (4 m,).

    `reference_run` gives the same by filterpy, in a hundred times as long.

    Parameters
    ----------
    design : array_like, shape (4 m,)
        Rates [deg/s] and duration [s] of each maneuver in turn.

    Raises
    ------
    ValueError
        If the covariance loses positivity, so that nothing follows from it.

    Examples
    --------
    >>> from mgeo_attitude import FilterModel, Scenario, filter_history
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> history = filter_history(FilterModel.from_scenario(Scenario.paper()), design)
    >>> bool(history.trace[-1] < history.trace[0])
    True
    """
    found = evaluate(model, np.atleast_2d(np.asarray(design, dtype=float)), 1, True, True)
    t_end = found.t_end[0]
    if np.isnan(t_end):
        raise ValueError(f"design {np.ravel(design).tolist()}: its covariance loses positivity")
    n = round(t_end / model.step) + 1
    variances = found.variances[0, :n]
    return FilterHistory(
        times=model.times[:n],
        trace=variances @ model.weights,
        sigma=np.sqrt(variances),
        attitude=Motion.of(model, design, n - 1).attitude,
        covariance=found.covariance[0],
        blocks=model.suite.blocks,
        converged=bool(t_end < model.longest),
    )


def can_measure(model: FilterModel, index: int, attitude: Floats, rates: Floats) -> Bools:
    """Of the first k + 1 samples those at which a sensor can measure, shape (k + 1,).

    Parameters
    ----------
    attitude : array, shape (k + 1, 3, 3)
        GCRS to body.
    rates : array, shape (k, 3)
        Body rate in each step [rad/s].
    """
    flown = slice(len(attitude))
    sensor, mask = model.suite.sensors[index], model.available[flown, index].copy()
    for view in sensor.views():
        looked_at, radius = model.references[flown, index], np.zeros(len(attitude))
        if view.direction:
            looked_at, radius = model.direction(view.direction, flown)
        cosine = np.einsum("kij,kj->ki", attitude, looked_at) @ view.axis
        mask &= (cosine >= np.cos(view.half_angle + radius)) == view.inside
    mask[1:] &= np.einsum("ki,ki->k", rates, rates) <= sensor.max_rate() ** 2
    return mask


def measurements(
    model: FilterModel, attitude: Floats, rates: Floats
) -> tuple[Floats, Floats, Bools]:
    """H and the diagonal of R of all m rows of sensors, and which are seen, at every sample.

    Parameters
    ----------
    attitude, rates : arrays
        See `can_measure`.

    Returns
    -------
    H, R, seen : arrays, shapes (n_steps + 1, m, n_states), (m,) and (n_steps + 1, m)
    """
    H: list[Floats] = []
    R: list[float] = []
    seen: list[Bools] = []
    before = np.vstack([rates[:1], rates])  # of the step that leads to a sample
    for index, sensor in enumerate(model.suite.sensors):
        v, *gradient = (
            np.einsum("kij,kj->ki", attitude, model.references[:, row])
            for row in model.suite.looks(index)
        )
        follows = [*model.influences[:, model.suite.influence_columns(sensor)].T]
        H.append(model.suite.measurement_matrix(sensor, v, attitude, gradient, before, follows))
        R.extend(sigma**2 for sigma in sensor.noise())
        seen.extend([can_measure(model, index, attitude, rates)] * len(sensor.noise()))
    return np.concatenate(H, axis=1), np.array(R), np.stack(seen, axis=1)
