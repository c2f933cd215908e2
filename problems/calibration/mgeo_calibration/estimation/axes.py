"""Axes in another order or with another sign, and rates of another size: what agrees far better."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations, product

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.geometry.rotation import exponential

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

#: What rates may be by mistake, and what they would have to be multiplied by.
RATE_FACTORS = {
    "in rad/s": float(np.degrees(1.0)),
    "in deg/h": 1.0 / 3600.0,
    "in rev/min": 6.0,
    "in mdeg/s": 1e-3,
    "ten times as large": 10.0,
    "a tenth as large": 0.1,
    "a hundred times as large": 100.0,
    "a hundredth as large": 0.01,
}

#: Name of a sensor; body and inertial unit vectors, shape (w, k, 3); weights, shape (w, k).
Seen = tuple[str, Floats, Floats, Floats]


def axes_causes(batch: Batch) -> Iterator[str]:
    """In words: the change of axes or rates that makes windows of samples agree far better."""
    bias = np.full(3, batch.suite.gyro.states()["bias"])
    windows = _windows(batch, carried_for(batch, bias, _ASTRAY))
    vectors = [i for i in range(len(batch.sensors)) if _is_vector(batch, i)]
    seen = [_seen(batch, i, windows) for i in vectors]
    if not len(windows) or not seen:
        return
    rates = (batch.gyro * batch.durations[:, None])[windows[:, :-1]]
    turned = _turned(rates)
    now = _misfit(seen, turned)
    found: list[tuple[float, int, str]] = []
    for P, changes, words in _signed():
        for k, (name, body, known, weight) in enumerate(seen):
            other = [*seen[:k], (name, body @ P.T, known, weight), *seen[k + 1 :]]
            found.append((_misfit(other, turned), changes, f"{name} {words}"))
        found.append((_misfit(seen, _turned(rates @ P.T)), changes, f"gyro {words}"))
    for unit, factor in RATE_FACTORS.items():
        words = f"gyro: the vectors turn as if its rates were {unit}"
        found.append((_misfit(seen, _turned(factor * rates)), 1, words))
    least = min(misfit for misfit, _, _ in found)
    lasts = batch.times[windows[:, -1]] - batch.times[windows[:, 0]]
    astray = float(np.median(bias[0] * lasts) ** 2) / 6.0  # of two numbers, about their mean
    well = _WELL * float(np.mean([_believed(batch, i) for i in vectors]) + astray)
    if least < min(_BETTER * now, well):
        yield min((n, misfit, words) for misfit, n, words in found if misfit < _AS_GOOD * least)[2]


def _signed() -> Iterator[tuple[Floats, int, str]]:
    """The 47 signed permutations of axes, how many of these they change, and words."""
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
                yield P, changes, f"agrees with all else if its axes are ({axes}), not (x, y, z)"


def _windows(batch: Batch, longest: int) -> Ints:
    """Samples of each window, one after the other, without a silence of the gyro."""
    n, rate = len(batch.times), np.linalg.norm(batch.gyro * batch.durations[:, None], axis=1)
    length = int(np.clip(_TURN / max(float(np.median(rate)), 1e-9), _SAMPLES, _LONGEST))
    length = max(_FEWEST, min(length, n, longest))
    first = np.unique(np.linspace(0, n - length, _WINDOWS).astype(int))
    found: Ints = first[:, None] + np.arange(length)
    silent = np.append(batch.breaks, False)[found[:, :-1]].any(axis=1)
    return found[~silent]


def _is_vector(batch: Batch, index: int) -> bool:
    rows = batch.sensors[index]
    return rows.shape[1:] == (1, 3) and bool(np.isfinite(rows[:, 0, 0]).sum() > 3 * _WINDOWS)


def _seen(batch: Batch, index: int, windows: Ints) -> Seen:
    picked = windows[:, _picks(windows)]
    body, known = batch.sensors[index][picked, 0], batch.vectors[picked, index]
    with np.errstate(over="ignore", invalid="ignore"):
        body = np.nan_to_num(body / np.linalg.norm(body, axis=-1, keepdims=True))
    known = known / np.linalg.norm(known, axis=-1, keepdims=True)
    there = body.any(axis=-1)
    count = there.sum(axis=1, keepdims=True)
    weight = np.where(count < _FEWEST, 0.0, there / np.maximum(count, 1))
    return batch.suite.sensors[index].name, body, known, weight


def _believed(batch: Batch, index: int) -> float:
    """Mean square of what noise, bias and misalignment, as believed, change a unit vector by."""
    places = batch.suite.places(batch.suite.sensors[index])
    sigma = Belief.initial(batch.suite).sigma
    bias, turned = (
        float((sigma[k : k + 3] ** 2).mean()) if (k := places.get(state)) else 0.0
        for state in ("bias", "misalignment")
    )
    square = float(np.median((batch.vectors[:, index] ** 2).sum(axis=1)))
    # of three numbers two are across
    return 2.0 * ((float((batch.noise[index] ** 2).mean()) + bias) / square + turned)


def _picks(windows: Ints) -> Ints:
    """Of the samples of a window those that are looked at."""
    picks: Ints = np.unique(np.linspace(0, windows.shape[1] - 1, _SAMPLES).astype(int))
    return picks


def _turned(angles: Floats) -> Floats:
    """Rotations from the body axes of picked samples to those of the first of the window.

    Parameters
    ----------
    angles : array, shape (w, n - 1, 3)
        By which the body turns in each step [rad].
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
    """What Wahba's problem leaves of a unit vector in a window, mean square over all windows."""
    profile, total = np.zeros((len(turned), 3, 3)), np.zeros(len(turned))
    for _, body, known, weight in seen:
        there = np.einsum("wkij,wkj->wki", turned, body)
        profile += np.einsum("wk,wki,wkj->wij", weight, known, there)
        total += weight.sum(axis=1)
    sizes = np.linalg.svd(profile, compute_uv=False)
    sizes[:, 2] *= np.sign(np.linalg.det(profile))
    some = total > 0.0
    return (
        float((2.0 * (1.0 - sizes[some].sum(axis=1) / total[some])).mean()) if some.any() else 0.0
    )
