"""Search for swapped axes and other orders of quaternions.

Short windows of samples are compared with what the vectors should be by Wahba's problem, once as
the telemetry says and once for each mistake.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations, product

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.geometry.rotation import exponential
from scipy.spatial.transform import Rotation

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.start import carried_for

#: Windows that are looked at, samples in each, and the angle that the body should turn by [rad].
_WINDOWS, _SAMPLES, _TURN = 24, 60, 0.5
_LONGEST, _FEWEST = 600, 5
_ASTRAY = 0.5  # by how much the gyro's bias may turn a window, 1-sigma [rad]
_WILD = 3.0  # a step does not turn by more [rad]
#: A cause leaves this share of the misfit; of those that leave hardly more the simplest is taken.
_BETTER, _AS_GOOD = 0.2, 1.5
_WELL = 5.0  # and no more than so many times what noise and errors as believed leave

#: Mistaken readings of quaternions: in words, which numbers are (x, y, z, scalar), and whether the
#: rotation is the inverse.
ORDERS = (
    ("scalar first", (1, 2, 3, 0), False),
    ("from the body to GCRF", (0, 1, 2, 3), True),
    ("scalar first, from the body to GCRF", (1, 2, 3, 0), True),
)

#: Body and inertial unit vectors, shape (w, k, m, 3), and weights, shape (w, k, m): of a tracker
#: the axes of GCRS.
Seen = tuple[Floats, Floats, Floats]


def axes_causes(batch: Batch) -> Iterator[str]:
    """Yield the mistake whose correction makes the windows agree far better, in words."""
    bias = np.full(3, batch.suite.gyro.states()["bias"])
    windows = _windows(batch, carried_for(batch, bias, _ASTRAY))
    sensors = [i for i in range(len(batch.sensors)) if _has_directions(batch.sensors[i])]
    if not len(windows) or not sensors:
        return
    picked = windows[:, _picks(windows)]
    seen = [_seen(batch, i, batch.sensors[i][picked], picked) for i in sensors]
    rates = (batch.gyro * batch.durations[:, None])[windows[:, :-1]]
    turned = _turned(rates)
    now = _misfit(seen, turned)
    found: list[tuple[float, int, str]] = []
    for k, i in enumerate(sensors):
        for changes, words, rows in _variants(batch.sensors[i][picked]):
            other = [*seen[:k], _seen(batch, i, rows, picked), *seen[k + 1 :]]
            words = f"{batch.suite.sensors[i].name}{words}"
            found.append((_misfit(other, turned), changes, words))
    for P, changes, words in _signed():
        found.append((_misfit(seen, _turned(rates @ P.T)), changes, f"gyro{words}"))
    least = min(misfit for misfit, _, _ in found)
    lasts = batch.times[windows[:, -1]] - batch.times[windows[:, 0]]
    astray = float(np.median(bias[0] * lasts) ** 2) / 6.0  # of two numbers, about their mean
    well = _WELL * float(np.mean([_believed(batch, i) for i in sensors]) + astray)
    if least < min(_BETTER * now, well):
        yield min((n, misfit, words) for misfit, n, words in found if misfit < _AS_GOOD * least)[2]


def _signed() -> Iterator[tuple[Floats, int, str]]:
    """Yield the 47 signed permutations of axes, the number of changed axes, and words."""
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            P = np.zeros((3, 3))
            P[range(3), order] = signs
            changes = int((np.diag(P) != 1.0).sum())
            if changes:
                axes = ", ".join(
                    f"{'-' if sign < 0.0 else ''}{'xyz'[axis]}"
                    for sign, axis in zip(signs, order, strict=True)
                )
                yield P, changes, f" agrees with all else if its axes are ({axes}), not (x, y, z)"


def _windows(batch: Batch, longest: int) -> Ints:
    """Return the samples of each window, shape (w, k); none spans a silence of the gyro."""
    n, rate = len(batch.times), np.linalg.norm(batch.gyro * batch.durations[:, None], axis=1)
    length = int(np.clip(_TURN / max(float(np.median(rate)), 1e-9), _SAMPLES, _LONGEST))
    length = max(_FEWEST, min(length, n, longest))
    first = np.unique(np.linspace(0, n - length, _WINDOWS).astype(int))
    found: Ints = first[:, None] + np.arange(length)
    silent = np.append(batch.breaks, False)[found[:, :-1]].any(axis=1)
    return found[~silent]


def _variants(rows: Floats) -> Iterator[tuple[int, str, Floats]]:
    """Yield the number of changed axes, words, and the corrected rows for each mistake."""
    if rows.shape[-2] == 1:
        yield from ((changes, words, rows @ P.T) for P, changes, words in _signed())
        return
    for words, order, inverse in ORDERS:
        says = f": its quaternions agree with all else if they are read as {words}: expected "
        says += "scalar last, from GCRF to the body"
        yield 1, says, _reread(rows, order, inverse)


def _reread(axes: Floats, order: tuple[int, ...], inverse: bool) -> Floats:
    """Return the axes, shape (w, k, 3, 3), of quaternions with their numbers in another order."""
    found = np.full_like(axes, np.nan)
    there = np.isfinite(axes).all(axis=(-2, -1))
    if there.any():
        rotations = Rotation.from_quat(Rotation.from_matrix(axes[there]).as_quat()[:, order])
        found[there] = (rotations.inv() if inverse else rotations).as_matrix()
    return found


def _has_directions(rows: Floats) -> bool:
    return rows.shape[2] == 3 and bool(np.isfinite(rows[:, 0, 0]).sum() > 3 * _WINDOWS)


def _seen(batch: Batch, index: int, body: Floats, picked: Ints) -> Seen:
    known = batch.vectors[picked, index][:, :, None] if body.shape[2] == 1 else np.eye(3)
    with np.errstate(over="ignore", invalid="ignore"):
        body = np.nan_to_num(body / np.linalg.norm(body, axis=-1, keepdims=True))
    known = np.broadcast_to(known / np.linalg.norm(known, axis=-1, keepdims=True), body.shape)
    there = body.any(axis=-1)
    count = there.sum(axis=(1, 2), keepdims=True)
    return body, known, np.where(count < _FEWEST, 0.0, there / np.maximum(count, 1))


def _believed(batch: Batch, index: int) -> float:
    """Return the expected mean square error of a unit vector [rad²]: noise, bias, misalignment."""
    places = batch.suite.places(batch.suite.sensors[index])
    sigma = Belief.initial(batch.suite).sigma
    bias, turned = (
        float((sigma[k : k + 3] ** 2).mean()) if (k := places.get(state)) else 0.0
        for state in ("bias", "misalignment")
    )
    tracker = batch.sensors[index].shape[1] == 3  # whose noise is an angle
    square = 1.0 if tracker else float(np.median((batch.vectors[:, index] ** 2).sum(axis=1)))
    # of three numbers two are across
    return 2.0 * ((float((batch.noise[index] ** 2).mean()) + bias) / square + turned)


def _picks(windows: Ints) -> Ints:
    """Return the positions within a window that are compared."""
    picks: Ints = np.unique(np.linspace(0, windows.shape[1] - 1, _SAMPLES).astype(int))
    return picks


def _turned(angles: Floats) -> Floats:
    """Return rotations from the body axes of the compared samples to those of the first sample.

    Parameters
    ----------
    angles : array, shape (w, n - 1, 3)
        Rotation of the body in each step [rad].

    Returns
    -------
    array, shape (w, k, 3, 3)
    """
    with np.errstate(over="ignore", invalid="ignore"):
        angles = np.clip(angles, -_WILD, _WILD)
    step = np.moveaxis(exponential(np.moveaxis(angles, -1, 0)), (0, 1), (-2, -1))
    w, n = angles.shape[:2]
    R = np.concatenate([np.broadcast_to(np.eye(3), (w, 1, 3, 3)), step], axis=1)
    reach = 1
    while reach <= n:  # products of 2, 4, 8... steps
        R[:, reach:] = R[:, :-reach] @ R[:, reach:]
        reach *= 2
    found: Floats = R[:, _picks(R)]
    return found


def _misfit(seen: Sequence[Seen], turned: Floats) -> float:
    """Return the mean square residual of Wahba's problem over all windows [rad²]."""
    profile, total = np.zeros((len(turned), 3, 3)), np.zeros(len(turned))
    for body, known, weight in seen:
        there = np.einsum("wkij,wkmj->wkmi", turned, body)
        profile += np.einsum("wkm,wkmi,wkmj->wij", weight, known, there)
        total += weight.sum(axis=(1, 2))
    sizes = np.linalg.svd(profile, compute_uv=False)
    sizes[:, 2] *= np.sign(np.linalg.det(profile))
    some = total > 0.0
    return (
        float((2.0 * (1.0 - sizes[some].sum(axis=1) / total[some])).mean()) if some.any() else 0.0
    )
