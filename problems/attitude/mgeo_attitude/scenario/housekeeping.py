"""Housekeeping channels along a plan, from a table or from a model of eclipses."""

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
    """Predicted values of a housekeeping channel, such as a temperature or a current.

    The values follow from a table, with linear interpolation and constant extrapolation, or from
    the first-order model u' = (v - u) / τ with different steady-state values v in sunlight and in
    eclipse.

    Examples
    --------
    >>> import numpy as np
    >>> from mgeo_attitude.scenario import Channel
    >>> current = Channel(name="current", times=(0.0, 10.0), values=(1.0, 3.0))
    >>> current.at(np.array([0.0, 5.0, 20.0]), np.ones(3, dtype=bool)).tolist()
    [1.0, 2.0, 3.0]
    """

    name: Identifier
    """name of the channel in influences and telemetry"""
    times: Annotated[tuple[float, ...], Unit("s")] = ()
    """times of the table, after the epoch"""
    values: tuple[float, ...] = ()
    """values of the table"""
    in_sunlight: float | None = None
    """steady-state value in sunlight"""
    in_shadow: float | None = None
    """steady-state value in eclipse"""
    time_constant: Seconds | None = Field(default=None, gt=0.0)
    """time constant of the first-order model"""
    initial: float | None = None
    """value at the epoch; default: the steady-state value"""

    def __post_init__(self) -> None:
        table = bool(self.times or self.values)
        for key in ("in_sunlight", "in_shadow", "time_constant"):
            value = getattr(self, key)
            expected = "no value with a table" if table else "a number, or a table"
            expect((value is None) == table, key, value, f"{expected}: times and values")
        if table:
            expect(self.initial is None, "initial", self.initial, "no value with a table")
            found, count = f"{len(self.values)} values", f"as many as times: {len(self.times)}"
            expect(len(self.values) == len(self.times), "values", found, count)
            expect((np.diff(self.times) > 0.0).all(), "times", self.times, "times that increase")
        expect(self.name != "time", "name", self.name, "a name other than 'time'")

    def compute_values(self, times: Floats, sunlit: Bools) -> Floats:
        """Return the values at n samples, shape (n,).

        A step counts as sunlit if its end is sunlit.
        """
        if self.times:
            return np.interp(times, self.times, self.values)
        assert self.in_sunlight is not None
        assert self.in_shadow is not None
        assert self.time_constant is not None
        goal = np.where(sunlit, self.in_sunlight, self.in_shadow)
        values = np.empty(len(times))
        values[0] = goal[0] if self.initial is None else self.initial
        left = np.exp(-np.diff(times) / self.time_constant)
        for k, share in enumerate(left, start=1):
            values[k] = goal[k] + (values[k - 1] - goal[k]) * share
        return values


def check_channels(channels: Sequence[HousekeepingChannel], suite: Suite) -> None:
    """Raise InvalidValue if a channel of an influence is not defined."""
    known = {channel.name for channel in channels}
    for key, influence in suite.sensitivities_by_key.items():
        name = influence.channel
        if name not in known:
            hint = (
                format_known_names(name, known)
                if known
                else ": there are no [[housekeeping_channels]]"
            )
            way = "define its values along the plan in [[housekeeping_channels]], or remove the influence"
            raise InvalidValue(f"{key}.channel", name, f"unknown channel{hint}; {way}")


def compute_channel_values(
    channels: Sequence[HousekeepingChannel], suite: Suite, times: Floats, sunlit: Bools
) -> Mapping[str, Floats]:
    """Return the values of all channels that influence a suite, shape (n,), by name.

    Raises
    ------
    InvalidValue
        If a channel of an influence is not defined.
    """
    check_channels(channels, suite)
    known = {channel.name: channel for channel in channels}
    used = dict.fromkeys(influence.channel for influence in suite.sensitivities_by_key.values())
    return {name: known[name].compute_values(times, sunlit) for name in used}
