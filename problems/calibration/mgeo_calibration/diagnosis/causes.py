"""What is the matter, in the order in which it is looked for; first, numbers not measured."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.scenario import Scenario

from mgeo_calibration.diagnosis.axes import axes_causes
from mgeo_calibration.diagnosis.clocks import clock_causes
from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.telemetry import Telemetry
from mgeo_calibration.telemetry.telemetry import channels

_OFTEN = 5  # times a number has to repeat
_MORE = 5  # by how often it does so more than any other
_LONG = 10  # samples in a row that are the same
_RARE = 0.01  # share of equal neighbors from which a channel says nothing
_NEAR = 0.05  # of a channel's range: how far the next number below a limit may be


def checks(
    scenario: Scenario, telemetry: Telemetry, data: Batch | None
) -> dict[str, tuple[str, ...]]:
    """What is seen without any attitude, in words, by what is looked at; the most certain first.

    Parameters
    ----------
    data : Batch, optional
        What was made of telemetry, if it could be.
    """
    return {
        "numbers": tuple(channel_causes(telemetry)),
        "times": tuple(clock_causes(scenario, telemetry)),
        "axes": () if data is None else tuple(axes_causes(data)),
    }


def causes(scenario: Scenario, telemetry: Telemetry, data: Batch | None) -> tuple[str, ...]:
    """All that `checks` say."""
    found = checks(scenario, telemetry, data)
    return tuple(words for said in found.values() for words in said)


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
