"""Errors that gyro, sensors and world declare as states.

Errors that are neither constant nor white are first-order Gauss-Markov processes. A bias or a
misalignment may follow a channel, such as a temperature or a current.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, MutableMapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, Literal

import numpy as np
import pydantic.dataclasses
from pydantic import Field

from mgeo_attitude.geometry.rotation import rotate
from mgeo_attitude.geometry.vector import Vec3
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, expect, expect_unique, known_names
from mgeo_attitude.settings.types import Degrees, NonNegative, Unit


@dataclass(frozen=True)
class GaussMarkov:
    """An error e' = -e / τ + white noise, stationary: an Ornstein-Uhlenbeck process.

    In `Sensor.states` it stands where a constant has its initial 1-sigma. Its autocorrelation
    after a time t is exp(-t / τ) (A. Gelb, Applied Optimal Estimation, 1974, section 2.2).

    Attributes
    ----------
    sigma : float or tuple of three
        1-sigma, of each axis if they differ; the same at all times.
    correlation_time : float
        τ [s].

    Examples
    --------
    >>> import numpy as np
    >>> from mgeo_attitude import GaussMarkov
    >>> drift = GaussMarkov(sigma=100.0, correlation_time=600.0)
    >>> round(float(drift.sigma**2 * np.exp(-600.0 / drift.correlation_time)))  # after 600 s
    3679
    """

    sigma: float | tuple[float, float, float]
    correlation_time: float

    @property
    def density(self) -> Any:
        """Power spectral density of the noise that drives it, per axis; a number or three."""
        return 2.0 * np.square(self.sigma) / self.correlation_time

    def over(self, duration: Any) -> tuple[Any, Any]:
        """Factor by which it decays over a duration [s], and the variance that comes new.

        Of an array of durations arrays; its last axis goes with those of `sigma`, if they differ.
        """
        ratio = duration / self.correlation_time
        return np.exp(-ratio), -np.square(self.sigma) * np.expm1(-2.0 * ratio)


@dataclass(frozen=True)
class Alike:
    """A constant whose three numbers hardly differ: one number, in a state of 3-vectors.

    Attributes
    ----------
    sigma : float
        Initial 1-sigma of each.
    correlation : float
        Of any two of them at the start; they differ by √(2 (1 - correlation)) sigma, 1-sigma.
    """

    sigma: float
    correlation: float = 0.9999


#: What is declared of a state: the initial 1-sigma of a constant, of each axis, or more.
State = float | tuple[float, float, float] | GaussMarkov | Alike


def sigma_of(state: State) -> float | tuple[float, float, float]:
    """Initial 1-sigma of a state, of each axis if they differ."""
    return state.sigma if isinstance(state, GaussMarkov | Alike) else state


@pydantic.dataclasses.dataclass(frozen=True)
class Influence(Settings):
    """A bias or misalignment that changes by c (u - u₀) with a channel's value u.

    The coefficient c is a constant of each axis.

    Examples
    --------
    >>> from mgeo_attitude import Gyro, Influence
    >>> list(Gyro(influences=(Influence("temp", 5e-4, "degC", 20.0),)).states())
    ['bias', 'bias_per_temp']
    """

    channel: str
    """name of the channel: of one of the scenario's channels, in telemetry of a column"""
    initial_sigma: float = Field(gt=0.0)
    """1-sigma of the change per unit of the channel and axis, in the unit of the initial bias
    (deg/s, nT, or of a unit vector), or in deg of a misalignment"""
    unit: str = "unit"
    """unit of the channel, for people"""
    reference: float = 0.0
    """value of the channel at which the error is the initial one"""
    error: Literal["bias", "misalignment"] = "bias"
    """error that follows the channel"""

    @property
    def state(self) -> str:
        """Name of its state."""
        return f"{self.error}_per_{self.channel}"

    def unit_of(self, error: Unit) -> Unit:
        """Return the unit of the state for an error in a unit."""
        return Unit(f"{error.text} per {self.unit}", error.suffix, error.factor)


def influenced(
    influences: Sequence[Influence],
    own: MutableMapping[str, Any],
    values: Sequence[Any],
    times: Callable[[Any, Any], Any] = lambda value, coefficient: value * coefficient,
) -> MutableMapping[str, Any]:
    """Add the effect of channels to the states of an owner, and remove the coefficients.

    Parameters
    ----------
    own : mapping
        States by their names, which is changed.
    values : sequence
        u - u₀ of each, in a shape that goes with the states'.
    times : function
        Product of a value and a state.
    """
    for influence, value in zip(influences, values, strict=True):
        known, change = own[influence.error], times(value, own.pop(influence.state))
        if influence.error == "bias" or isinstance(known, Vec3):
            own[influence.error] = known + change
        else:
            own[influence.error] = partial(_rotate_twice, known, change)
    return own


def _rotate_twice(last: Any, first: Any, vector: Any) -> Any:
    return rotate(last, rotate(first, vector))


def by_axis(sigma: float | tuple[float, float, float]) -> tuple[float, float, float]:
    """Of each axis, where one number may stand for all."""
    return sigma if isinstance(sigma, tuple) else (sigma, sigma, sigma)


def present(**sigmas: float) -> dict[str, State]:
    """Return the constants among states by their initial 1-sigmas, without those of zero."""
    return {state: sigma for state, sigma in sigmas.items() if sigma}


Misalignment = Annotated[
    Degrees,
    Field(
        ge=0.0,
        description="initial misalignment, 1-sigma per axis; 0 leaves the states out: it says what "
        "body axes are",
    ),
]
ScaleFactor = Annotated[
    NonNegative,
    Field(description="initial scale-factor error, 1-sigma per axis; 0 leaves the states out"),
]
#: See `vector.shear`.
Nonorthogonality = Annotated[
    Degrees,
    Field(
        ge=0.0,
        description="initial non-orthogonality, half of what two axes are off a right angle, "
        "1-sigma; 0 leaves the states out",
    ),
]


def check_influences(influences: Sequence[Influence], states: Collection[str], kind: str) -> None:
    """Refuse, with an InvalidValue, an influence that is repeated, or on an error that is none."""
    for i, influence in enumerate(influences):
        none = f"none: {kind} has no {influence.error} that follows it"
        there = {influence.state, influence.error} <= set(states)
        expect(there, f"influences[{i}].channel", influence.channel, none)
    expect_unique("influences[{}].channel", [influence.state for influence in influences])


def check_considered(considered: Sequence[str], states: Collection[str]) -> None:
    """Refuse, with an InvalidValue, what is none of the states, or twice there."""
    expect_unique("considered[{}]", considered)
    for i, state in enumerate(considered):
        if state not in states:
            expected = f"unknown state{known_names(state, states)}"
            raise InvalidValue(f"considered[{i}]", state, expected)
