"""Search for permuted axes of sensors and gyro, and for other quaternion conventions.

Wahba's problem is solved in short windows of samples, for the readings as declared and for each
possible mistake. A calibration that fails uses the result to suggest a cause.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations, product

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.geometry.rotation import exponential_map
from scipy.spatial.transform import Rotation

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.initial_attitude import count_propagated_samples
from mgeo_calibration.estimation.prior import PriorEstimate

#: Number of windows, compared samples in each window, and desired rotation within a window [rad].
_N_WINDOWS, _N_SAMPLES, _WINDOW_ROTATION = 24, 60, 0.5
_MAX_WINDOW_LENGTH, _MIN_SAMPLES = 600, 5
#: Largest rotation of a window by the gyro bias, 1-sigma, and largest rotation in a step [rad].
_MAX_BIAS_ROTATION, _MAX_STEP_ROTATION = 0.5, 3.0
#: Largest misfit after a correction relative to the original misfit, and largest misfit relative to
#: the best correction. Among the corrections within both bounds, the simplest is reported.
_MAX_MISFIT_RATIO, _MAX_RATIO_TO_BEST = 0.2, 1.5
#: Largest misfit after a correction relative to the misfit that the prior predicts.
_MAX_RATIO_TO_EXPECTED = 5.0

#: Quaternion conventions: description, positions of (x, y, z, scalar), and whether the rotation is
#: the inverse.
QUATERNION_CONVENTIONS = (
    ("scalar first", (1, 2, 3, 0), False),
    ("from the body to GCRF", (0, 1, 2, 3), True),
    ("scalar first, from the body to GCRF", (1, 2, 3, 0), True),
)

#: Body and inertial unit vectors, shape (w, k, m, 3), and weights, shape (w, k, m). A star tracker
#: observes the axes of GCRS.
WindowVectors = tuple[Floats, Floats, Floats]


def find_axis_mistakes(batch: Batch) -> Iterator[str]:
    """Search for the axis permutation or quaternion convention that makes sensors and gyro agree.
    Yield at most one description.

    Nothing is yielded if the readings as declared already agree, or if no correction is sufficient.

    Parameters
    ----------
    batch : Batch
        Batch of a calibration that failed.

    Yields
    ------
    str
        Cause for a message, with the name of the sensor or gyro.
    """
    bias = np.full(3, batch.suite.gyro.states()["bias"])
    windows = _select_windows(batch, count_propagated_samples(batch, bias, _MAX_BIAS_ROTATION))
    sensors = [i for i in range(len(batch.readings)) if _has_directions(batch.readings[i])]
    if not len(windows) or not sensors:
        return
    samples = windows[:, _select_samples(windows)]
    vectors = [_normalize_vectors(batch, i, batch.readings[i][samples], samples) for i in sensors]
    rates = (batch.gyro_rates * batch.durations[:, None])[windows[:, :-1]]
    rotations = _accumulate_rotations(rates)
    declared_misfit = _compute_misfit(vectors, rotations)
    result: list[tuple[float, int, str]] = []
    for k, i in enumerate(sensors):
        for n_changes, description, readings in _correct_mistakes(batch.readings[i][samples]):
            corrected = [
                *vectors[:k],
                _normalize_vectors(batch, i, readings, samples),
                *vectors[k + 1 :],
            ]
            description = f"{batch.suite.sensors[i].name}{description}"
            result.append((_compute_misfit(corrected, rotations), n_changes, description))
    for P, n_changes, description in _permute_axes():
        result.append(
            (
                _compute_misfit(vectors, _accumulate_rotations(rates @ P.T)),
                n_changes,
                f"gyro{description}",
            )
        )
    min_misfit = min(misfit for misfit, _, _ in result)
    window_durations = batch.times[windows[:, -1]] - batch.times[windows[:, 0]]
    bias_misfit = float(np.median(bias[0] * window_durations) ** 2) / 6.0
    max_misfit = _MAX_RATIO_TO_EXPECTED * float(
        np.mean([_predict_misfit(batch, i) for i in sensors]) + bias_misfit
    )
    if min_misfit < min(_MAX_MISFIT_RATIO * declared_misfit, max_misfit):
        yield min(
            (n_changes, misfit, description)
            for misfit, n_changes, description in result
            if misfit < _MAX_RATIO_TO_BEST * min_misfit
        )[2]


def _permute_axes() -> Iterator[tuple[Floats, int, str]]:
    """Yield the matrix, the number of changed axes and a description of each signed axis
    permutation except the identity.
    """
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            P = np.zeros((3, 3))
            P[range(3), order] = signs
            n_changes = int((np.diag(P) != 1.0).sum())
            if n_changes:
                axes = ", ".join(
                    f"{'-' if sign < 0.0 else ''}{'xyz'[axis]}"
                    for sign, axis in zip(signs, order, strict=True)
                )
                yield (
                    P,
                    n_changes,
                    f" agrees with the other sensors if its axes are ({axes}), not (x, y, z). "
                    "Correct the order and the signs of its columns in the mapping",
                )


def _select_windows(batch: Batch, max_length: int) -> Ints:
    """Return the sample indices of short, evenly spaced windows without gyro breaks, as an array of
    shape (w, k).
    """
    n, rate = len(batch.times), np.linalg.norm(batch.gyro_rates * batch.durations[:, None], axis=1)
    length = int(
        np.clip(
            _WINDOW_ROTATION / max(float(np.median(rate)), 1e-9), _N_SAMPLES, _MAX_WINDOW_LENGTH
        )
    )
    length = max(_MIN_SAMPLES, min(length, n, max_length))
    first = np.unique(np.linspace(0, n - length, _N_WINDOWS).astype(int))
    result: Ints = first[:, None] + np.arange(length)
    has_break = np.append(batch.breaks, False)[result[:, :-1]].any(axis=1)
    return result[~has_break]


def _correct_mistakes(readings: Floats) -> Iterator[tuple[int, str, Floats]]:
    """Yield the number of changed axes, a description and the corrected readings for each possible
    mistake in the declaration of a sensor.
    """
    if readings.shape[-2] == 1:
        yield from (
            (n_changes, description, readings @ P.T)
            for P, n_changes, description in _permute_axes()
        )
        return
    for convention, order, inverse in QUATERNION_CONVENTIONS:
        description = (
            ": its quaternions agree with the other sensors if they are read as "
            f"{convention}: expected scalar last, from GCRF to the body. Declare scalar or "
            "attitude in the mapping"
        )
        yield 1, description, _convert_quaternions(readings, order, inverse)


def _convert_quaternions(axes: Floats, order: tuple[int, ...], inverse: bool) -> Floats:
    result = np.full_like(axes, np.nan)
    has_reading = np.isfinite(axes).all(axis=(-2, -1))
    if has_reading.any():
        rotations = Rotation.from_quat(Rotation.from_matrix(axes[has_reading]).as_quat()[:, order])
        result[has_reading] = (rotations.inv() if inverse else rotations).as_matrix()
    return result


def _has_directions(readings: Floats) -> bool:
    return readings.shape[2] == 3 and bool(np.isfinite(readings[:, 0, 0]).sum() > 3 * _N_WINDOWS)


def _normalize_vectors(batch: Batch, index: int, body: Floats, samples: Ints) -> WindowVectors:
    references = batch.vectors[samples, index][:, :, None] if body.shape[2] == 1 else np.eye(3)
    with np.errstate(over="ignore", invalid="ignore"):
        body = np.nan_to_num(body / np.linalg.norm(body, axis=-1, keepdims=True))
    references = np.broadcast_to(
        references / np.linalg.norm(references, axis=-1, keepdims=True), body.shape
    )
    is_nonzero = body.any(axis=-1)
    count = is_nonzero.sum(axis=(1, 2), keepdims=True)
    return body, references, np.where(count < _MIN_SAMPLES, 0.0, is_nonzero / np.maximum(count, 1))


def _predict_misfit(batch: Batch, index: int) -> float:
    """Predict the mean squared error [rad²] of a sensor's unit vectors from its noise and the prior
    1-sigmas of its bias and misalignment.
    """
    first_indices = batch.suite.get_first_indices(batch.suite.sensors[index])
    sigma = PriorEstimate.from_suite(batch.suite).sigma
    bias, misalignment = (
        float((sigma[k : k + 3] ** 2).mean()) if (k := first_indices.get(state)) else 0.0
        for state in ("bias", "misalignment")
    )
    is_tracker = batch.readings[index].shape[1] == 3  # The noise of a star tracker is an angle.
    square = 1.0 if is_tracker else float(np.median((batch.vectors[:, index] ** 2).sum(axis=1)))
    # Two of the three components are perpendicular to the vector.
    return 2.0 * ((float((batch.noise[index] ** 2).mean()) + bias) / square + misalignment)


def _select_samples(windows: Ints) -> Ints:
    samples: Ints = np.unique(np.linspace(0, windows.shape[1] - 1, _N_SAMPLES).astype(int))
    return samples


def _accumulate_rotations(angles: Floats) -> Floats:
    """Return rotation matrices from the body frame at selected samples of each window to the body
    frame at the start of the window.

    Parameters
    ----------
    angles : array, shape (w, n - 1, 3)
        Rotation vector of the body in each step [rad].

    Returns
    -------
    array, shape (w, k, 3, 3)
    """
    with np.errstate(over="ignore", invalid="ignore"):
        angles = np.clip(angles, -_MAX_STEP_ROTATION, _MAX_STEP_ROTATION)
    step_rotations = np.moveaxis(exponential_map(np.moveaxis(angles, -1, 0)), (0, 1), (-2, -1))
    w, n = angles.shape[:2]
    R = np.concatenate([np.broadcast_to(np.eye(3), (w, 1, 3, 3)), step_rotations], axis=1)
    reach = 1
    while reach <= n:  # The products contain 2, 4, 8, ... steps.
        R[:, reach:] = R[:, :-reach] @ R[:, reach:]
        reach *= 2
    result: Floats = R[:, _select_samples(R)]
    return result


def _compute_misfit(vectors: Sequence[WindowVectors], rotations: Floats) -> float:
    """Solve Wahba's problem in each window, and return the mean squared residual [rad²] over all
    windows.
    """
    profile, total = np.zeros((len(rotations), 3, 3)), np.zeros(len(rotations))
    for body, references, weight in vectors:
        rotated = np.einsum("wkij,wkmj->wkmi", rotations, body)
        profile += np.einsum("wkm,wkmi,wkmj->wij", weight, references, rotated)
        total += weight.sum(axis=(1, 2))
    sizes = np.linalg.svd(profile, compute_uv=False)
    sizes[:, 2] *= np.sign(np.linalg.det(profile))
    has_vectors = total > 0.0
    return (
        float((2.0 * (1.0 - sizes[has_vectors].sum(axis=1) / total[has_vectors])).mean())
        if has_vectors.any()
        else 0.0
    )
