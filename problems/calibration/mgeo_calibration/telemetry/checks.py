"""What telemetry cannot be: stuck, saturated, of another time; one line says what is wrong."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.environment.constants import DAY, FIELD_MODEL_END, FIELD_MODEL_START
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.settings.errors import InvalidValue, known_names

from mgeo_calibration.telemetry.columns import channel_of
from mgeo_calibration.telemetry.gyro_samples import reported
from mgeo_calibration.telemetry.telemetry import Telemetry, channels

#: Longest time without any sample [s]; what is longer is a clock that jumped.
LONGEST_SILENCE = DAY

_FEWEST = 10  # samples that say whether a channel is stuck
_CLIPPED = 5  # samples in a row at the same extreme
_OFTEN = 5  # times a number has to repeat
_MORE = 5  # by how often it does so more than any other
_LONG = 10  # samples in a row that are the same
_RARE = 0.01  # share of equal neighbors from which a channel says nothing
_NEAR = 0.05  # of a channel's range: how far the next number below a limit may be


def check_telemetry(telemetry: Telemetry, scenario: Scenario) -> None:
    """Refuse telemetry that nothing can be learned from.

    Raises
    ------
    ValueError
        For a gyro or sensors without samples, or a time outside the field model or that jumps.
    """
    _check_times(telemetry.times, scenario)
    reported(telemetry)
    if not any(np.isfinite(rows).any() for rows in telemetry.sensors.values()):
        raise ValueError(f"{', '.join(telemetry.sensors)}: expected a sample of one of them")


def followed(suite: Suite, others: Mapping[str, Floats]) -> dict[str, Floats]:
    """Channels that biases of a suite follow, by their names, of other columns of telemetry.

    Raises
    ------
    InvalidValue
        Naming the influence whose channel is not there.
    """
    found = {}
    for key, influence in suite.influence_keys.items():
        name = channel_of(others, influence.channel)
        if name is None:
            hint = known_names(influence.channel, others) if others else ": it has no other columns"
            way = "; give it a column of this name, or take the influence out of the scenario"
            expected = f"expected a column of the telemetry{hint}{way}"
            raise InvalidValue(f"{key}.channel", influence.channel, expected)
        found[influence.channel] = others[name]
    return found


def check_saturation(names: Sequence[str], rates: Floats, unit: str) -> None:
    """Refuse a gyro that saturates, by its rates along its own axes, shape (n, 3).

    Raises
    ------
    ValueError
        For the same largest rate many times in a row, in a column, by its name, whose neighbors
        otherwise differ.
    """
    for name, rate in zip(names, rates[np.isfinite(rates).all(axis=1)].T, strict=True):
        same = np.diff(rate) == 0.0
        extreme = same & (np.abs(rate[1:]) == np.abs(rate).max(initial=0.0))
        longest = int(_runs(extreme)[0].max(initial=0)) + 1
        if longest >= _CLIPPED and (same & ~extreme).sum() < _RARE * len(rate):
            raise ValueError(
                f"{name} = {np.abs(rate).max():.6g} {unit} in {longest} samples one after the "
                "other, and never beyond: the gyro saturates"
            )


def _check_times(times: Floats, scenario: Scenario) -> None:
    start, end = (
        (limit - scenario.epoch).total_seconds() for limit in (FIELD_MODEL_START, FIELD_MODEL_END)
    )
    silent = np.diff(times) > LONGEST_SILENCE
    if silent.any():
        k = int(np.argmax(silent))
        raise ValueError(
            f"time jumps from {times[k]:.6f} to {times[k + 1]:.6f} s: expected a sample at least "
            f"every {LONGEST_SILENCE:g} s"
        )
    if not (start <= times[0] and times[-1] <= end):
        at = times[0] if times[0] < start else times[-1]
        raise ValueError(
            f"time {at:.6f} s after the epoch: expected one in the years of the field model "
            f"IGRF-14, from {FIELD_MODEL_START:%Y-%m-%d} to {FIELD_MODEL_END:%Y-%m-%d}"
        )


def check_changes(names: Sequence[str], rows: Floats) -> None:
    """Refuse columns, by their names, of a gyro or sensor of which one never changes.

    Raises
    ------
    ValueError
        For one of three, or all.
    """
    found = rows[np.isfinite(rows).all(axis=1)]
    if len(found) < _FEWEST:
        return
    if len(names) == 1 and not found.any():  # a photodiode that has seen no Sun
        return
    stuck = np.ptp(found, axis=0) == 0.0
    if stuck.all() or (stuck.any() and len(names) == 3):
        k = int(np.argmax(stuck))
        raise ValueError(
            f"{names[k]} is {float(found[0, k])!r} in all {len(found)} samples: expected a channel "
            "that changes"
        )


def channel_causes(telemetry: Telemetry) -> Iterator[str]:
    """In words, of gyro and sensors."""
    for name, rows in {"gyro": telemetry.gyro_deg_s, **telemetry.sensors}.items():
        there = np.isfinite(rows).all(axis=1)
        if rows.shape[1] == 1:  # many photodiodes read zero in the dark
            there &= rows[:, 0] != 0.0
        times, found = telemetry.times[there], rows[there]
        if len(found) < 2 * _LONG:
            continue
        if words := _frozen(times, found):
            yield f"{name} {words}"
            continue
        for column, values in zip(channels(name, rows.shape[1]), found.T, strict=True):
            if words := _repeated(values):
                yield f"{column} {words}"


def _frozen(times: Floats, rows: Floats) -> str | None:
    """Of samples that repeat the one before in all channels."""
    lengths, starts = _runs((np.diff(rows, axis=0) == 0.0).all(axis=1))
    if not len(lengths):
        return None
    longest = int(lengths.argmax())
    usual = lengths[lengths < _LONG].sum()
    if (
        len(lengths) > len(rows) / _LONG / 2
        and np.median(lengths) >= 1
        and usual > _RARE * len(rows)
    ):
        held = float(np.median(lengths)) + 1.0
        if (len(lengths) + lengths.sum()) > 0.9 * len(rows):
            return f"repeats each of its samples {held:g} times: expected empty cells between them"
        return None
    if lengths[longest] + 1 < _LONG or usual > _RARE * len(rows):
        return None
    total, low = int(lengths[lengths >= _LONG - 1].sum()), starts[longest]
    return (
        f"does not change from {times[low]:.6g} to {times[low + lengths[longest]]:.6g} s, "
        f"{total + 1} samples that stand still: leave them out"
    )


def _repeated(values: Floats) -> str | None:
    """Of a number that is there more often than a measured one would be."""
    numbers, counts = np.unique(values, return_counts=True)
    if len(numbers) < _LONG:
        return None
    most = int(counts.argmax())
    inner = np.delete(counts, [0, most, len(counts) - 1] if 0 < most < len(counts) - 1 else [0, -1])
    if counts[most] < max(_OFTEN, _MORE * inner.max()):
        return None
    value, count = numbers[most], counts[most]
    rest = numbers[1:-1]
    if most in (0, len(numbers) - 1):
        gap = abs(value - numbers[1 if most == 0 else -2])
        if gap < _NEAR * np.ptp(rest):
            how = "below" if most == 0 else "above"
            return (
                f"is {value:.6g} in {count} of {len(values)} samples and never {how}: it is clipped"
            )
    return (
        f"is {value:.6g} in {count} of {len(values)} samples: a fill value? Expected empty cells "
        "where nothing was measured"
    )


def _runs(true: np.ndarray) -> tuple[Ints, Ints]:
    """Lengths of the runs of True, and where they begin."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], true, [False]]).astype(int)))
    return edges[1::2] - edges[::2], edges[::2]
