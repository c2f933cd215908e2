"""Checks of single telemetry channels for constant, saturated, frozen, repeated and clipped
values.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from mgeo_attitude._typing import Floats, Ints

from mgeo_calibration.telemetry.findings import Finding, Samples

_MIN_SAMPLES = 10  # smallest number of samples for a constant channel
_MAX_DARK_READING = 1e-9  # largest reading of a photodiode in the dark
_MIN_SATURATED_SAMPLES = 5  # smallest number of consecutive equal extremes of a saturated rate
_MIN_REPETITIONS = 5  # smallest count of a repeated value, also relative to the next frequent value
_MIN_FROZEN_SAMPLES = 10  # smallest number of consecutive equal samples of a frozen sensor
_MAX_EQUAL_FRACTION = 0.01  # largest fraction of equal neighbors of a finely resolved channel
# largest gap next to a clipping limit, relative to the range of the channel
_MAX_CLIPPING_GAP = 0.05


def find_constant_channels(samples: Samples) -> Iterator[Finding]:
    """Yield a finding for each gyro or sensor that has a channel with a constant value."""
    for name, (columns, rows) in samples.columns.items():
        indices = np.flatnonzero(np.isfinite(rows).all(axis=1))
        result = rows[indices]
        reported = samples.telemetry.sensors.get(name, rows)[indices]
        # A photodiode in the dark is constant without a fault.
        in_the_dark = len(columns) == 1 and (np.abs(reported) < _MAX_DARK_READING).all()
        if len(result) < _MIN_SAMPLES or in_the_dark:
            continue
        stuck = np.ptp(result, axis=0) == 0.0
        if stuck.all() or (stuck.any() and len(columns) == 3):
            k = int(np.argmax(stuck))
            value = f"{float(result[0, k])!r} in all {len(result)} samples"
            advice = f"check {name}.columns, or remove {name} from the scenario"
            place = samples.format_place(indices[0])
            yield Finding(columns[k], place, value, "a channel that changes", advice)


def find_saturated_rates(samples: Samples) -> Iterator[Finding]:
    """Yield a finding for each gyro axis that reaches its declared range or stays at an extreme
    rate.
    """
    if "gyro" not in samples.columns:
        return
    (columns, rows), gyro = samples.columns["gyro"], samples.mapping.gyro
    indices = np.flatnonzero(np.isfinite(rows).all(axis=1))
    advice = "remove these samples, or correct gyro.range_deg_s"
    unit = gyro.unit or "deg/s"
    limit = np.inf if gyro.range_deg_s is None else gyro.range_deg_s / gyro.compute_factor("deg/s")
    for name, rate in zip(columns, np.abs(rows[indices].T), strict=True):
        if (rate >= limit).any():
            k = int(np.argmax(rate >= limit))
            expected = f"less than range_deg_s, {limit:.6g} {unit}"
            value = f"{rate[k]:.6g} {unit}"
            yield Finding(name, samples.format_place(indices[k]), value, expected, advice)
    for name, rate in zip(columns, rows[indices].T, strict=True):
        same = np.diff(rate) == 0.0
        extreme = same & (np.abs(rate[1:]) == np.abs(rate).max(initial=0.0))
        lengths, starts = _find_runs(extreme)
        longest = int(lengths.max(initial=0)) + 1
        if longest >= _MIN_SATURATED_SAMPLES and (
            same & ~extreme
        ).sum() < _MAX_EQUAL_FRACTION * len(rate):
            k = starts[int(lengths.argmax())]
            value = f"{rate[k]:.6g} {unit} in {longest} samples in a row, and never beyond"
            place = samples.format_place(indices[k])
            yield Finding(name, place, value, "a gyro that does not saturate", advice)


def find_repeated_samples(samples: Samples) -> Iterator[Finding]:
    """Yield a finding for each gyro or sensor that repeats every sample or freezes for a while."""
    for name, _, indices, rows in _select_readings(samples):
        lengths, starts = _find_runs((np.diff(rows, axis=0) == 0.0).all(axis=1))
        if not len(lengths):
            continue
        longest, usual = int(lengths.argmax()), lengths[lengths < _MIN_FROZEN_SAMPLES].sum()
        rests = usual > _MAX_EQUAL_FRACTION * len(rows)
        if rests and (len(lengths) + lengths.sum()) > 0.9 * len(rows):
            value = f"each sample {np.median(lengths) + 1.0:g} times"
            expected, advice = "each sample once", "leave the cells between samples empty"
            yield Finding(name, samples.format_place(indices[0]), value, expected, advice)
        elif not rests and lengths[longest] + 1 >= _MIN_FROZEN_SAMPLES:
            first, last = starts[longest], starts[longest] + lengths[longest]
            value = f"{last - first + 1} equal samples, until {samples.format_place(indices[last])}"
            advice = "leave the cells of frozen samples empty"
            yield Finding(name, samples.format_place(indices[first]), value, "noise", advice)


def find_repeated_numbers(samples: Samples) -> Iterator[Finding]:
    """Yield a finding for each channel in which one value is unusually frequent, such as a fill
    value or a clipping limit.
    """
    for _, columns, indices, rows in _select_readings(samples):
        for column, values in zip(columns, rows.T, strict=True):
            numbers, counts = np.unique(values, return_counts=True)
            if len(numbers) < _MIN_FROZEN_SAMPLES:
                continue
            most = int(counts.argmax())
            others = np.delete(counts, sorted({0, most, len(counts) - 1}))
            if counts[most] < max(_MIN_REPETITIONS, _MIN_REPETITIONS * others.max()):
                continue
            expected, advice = "a measured value", "leave cells without a measurement empty"
            value = f"{numbers[most]:.6g} in {counts[most]} of {len(values)} samples"
            if most in (0, len(numbers) - 1):
                gap = abs(numbers[most] - numbers[1 if most == 0 else -2])
                if gap < _MAX_CLIPPING_GAP * np.ptp(numbers[1:-1]):
                    value += f", and never {'below' if most == 0 else 'above'}"
                    expected, advice = "a channel that is not clipped", "remove these samples"
            k = int(np.argmax(values == numbers[most]))
            yield Finding(column, samples.format_place(indices[k]), value, expected, advice)


def _select_readings(samples: Samples) -> Iterator[tuple[str, list[str], Ints, Floats]]:
    for name, (columns, rows) in samples.columns.items():
        is_complete = np.isfinite(rows).all(axis=1)
        if rows.shape[1] == 1:  # Photodiodes read zero in the dark.
            is_complete &= rows[:, 0] != 0.0
        if is_complete.sum() >= 2 * _MIN_FROZEN_SAMPLES:
            yield name, list(columns), np.flatnonzero(is_complete), rows[is_complete]


def _find_runs(mask: np.ndarray) -> tuple[Ints, Ints]:
    """Return the lengths and start indices of the runs of True in a boolean array."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    return edges[1::2] - edges[::2], edges[::2]
