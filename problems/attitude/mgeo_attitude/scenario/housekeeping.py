"""Housekeeping channels, such as temperatures, along a plan: from a table or from a model of
eclipses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, expect, format_known_names
from mgeo_attitude.settings.types import Identifier, Seconds, Unit


@dataclass(frozen=True, kw_only=True)
class HousekeepingChannel(Settings):
    """Prediction of a housekeeping channel, such as a temperature or a current, during a plan.

    The values follow from a table, with linear interpolation and constant extrapolation, or from
    the first-order model u' = (v - u) / τ with different steady-state values v in sunlight and in
    eclipse.

    Examples
    --------
    >>> import numpy as np
    >>> from mgeo_attitude.scenario import HousekeepingChannel
    >>> current = HousekeepingChannel(name="current", times=(0.0, 10.0), values=(1.0, 3.0))
    >>> current.compute_values(np.array([0.0, 5.0, 20.0]), np.ones(3, dtype=bool)).tolist()
    [1.0, 2.0, 3.0]
    """

    name: Identifier
    """name of the channel in bias_sensitivities and telemetry"""
    times: Annotated[tuple[float, ...], Unit("s")] = ()
    """times of the table, after the epoch, in ascending order"""
    values: tuple[float, ...] = ()
    """values of the table, one per time"""
    in_sunlight: float | None = None
    """steady-state value in sunlight; with in_shadow and time_constant, an alternative to the
    table"""
    in_shadow: float | None = None
    """steady-state value in eclipse"""
    time_constant: Seconds | None = Field(default=None, gt=0.0)
    """time constant with which the channel approaches its steady-state value"""
    initial: float | None = None
    """value at the epoch; default: the steady-state value"""

    def __post_init__(self) -> None:
        has_table = bool(self.times or self.values)
        for key in ("in_sunlight", "in_shadow", "time_constant"):
            value = getattr(self, key)
            expected = "no value with a table" if has_table else "a number, or a table"
            expected += " of times and values"
            expect((value is None) == has_table, key, value, expected)
        if has_table:
            expected = "no value with the table of times and values"
            expect(self.initial is None, "initial", self.initial, expected)
            n_values, n_times = f"{len(self.values)} values", f"as many as times: {len(self.times)}"
            expect(len(self.values) == len(self.times), "values", n_values, n_times)
            expect((np.diff(self.times) > 0.0).all(), "times", self.times, "ascending times")
        expect(self.name != "time", "name", self.name, "a name other than 'time'")

    def compute_values(self, times: Floats, sunlit: Bools) -> Floats:
        """Return the value of the channel at each sample, shape (n,).

        A step counts as sunlit if its end is sunlit.

        Parameters
        ----------
        times : array, shape (n,)
            Times after the epoch [s].
        sunlit : array of bool, shape (n,)
            Whether the satellite is in sunlight.
        """
        if self.times:
            return np.interp(times, self.times, self.values)
        assert self.in_sunlight is not None
        assert self.in_shadow is not None
        assert self.time_constant is not None
        steady_state = np.where(sunlit, self.in_sunlight, self.in_shadow)
        values = np.empty(len(times))
        values[0] = steady_state[0] if self.initial is None else self.initial
        decay = np.exp(-np.diff(times) / self.time_constant)
        for k, factor in enumerate(decay, start=1):
            values[k] = steady_state[k] + (values[k - 1] - steady_state[k]) * factor
        return values


def check_channels(channels: Sequence[HousekeepingChannel], suite: Suite) -> None:
    """Raise InvalidValue if a bias sensitivity refers to an undefined housekeeping channel."""
    known = {channel.name for channel in channels}
    for key, sensitivity in suite.sensitivities_by_key.items():
        name = sensitivity.channel
        if name not in known:
            hint = ": there are no [[housekeeping_channels]]"
            if known:
                hint = format_known_names(name, known)
            expected = (
                f"unknown channel{hint}; define its values along the plan in "
                "[[housekeeping_channels]], or remove the bias sensitivity"
            )
            raise InvalidValue(f"{key}.channel", name, expected)


def compute_channel_values(
    channels: Sequence[HousekeepingChannel], suite: Suite, times: Floats, sunlit: Bools
) -> Mapping[str, Floats]:
    """Return a dict with the values of all housekeeping channels on which biases depend.

    Parameters
    ----------
    channels : sequence of HousekeepingChannel
        Channels of the scenario.
    suite : Suite
        Gyro and sensors with bias sensitivities.
    times : array, shape (n,)
        Times after the epoch [s].
    sunlit : array of bool, shape (n,)
        Whether the satellite is in sunlight.

    Returns
    -------
    dict of str to array, shape (n,)

    Raises
    ------
    InvalidValue
        If the channel of a bias sensitivity is not defined.
    """
    check_channels(channels, suite)
    by_name = {channel.name: channel for channel in channels}
    used = dict.fromkeys(each.channel for each in suite.sensitivities_by_key.values())
    return {name: by_name[name].compute_values(times, sunlit) for name in used}
