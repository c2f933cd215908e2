"""Error models of gyro, sensors and environment models that enter the error state.

A time-varying error is a first-order Gauss-Markov process. A bias or misalignment may depend on a
housekeeping channel, such as a temperature or a current.
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
from mgeo_attitude.settings.errors import InvalidValue, expect, expect_unique, format_known_names
from mgeo_attitude.settings.types import Degrees, NonNegative, Unit


@dataclass(frozen=True)
class GaussMarkov:
    """Stationary first-order Gauss-Markov process e' = -e / τ + white noise (Ornstein-Uhlenbeck).

    In `Sensor.states`, the process replaces the initial 1-sigma of a constant. Its autocorrelation
    after a time t is exp(-t / τ) (A. Gelb, Applied Optimal Estimation, 1974, section 2.2).

    Attributes
    ----------
    sigma : float or tuple of three
        Stationary 1-sigma, for all axes or per axis.
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
    def noise_density(self) -> Any:
        """Power spectral density of the driving noise, one number or one per axis."""
        return 2.0 * np.square(self.sigma) / self.correlation_time

    def discretize(self, duration: Any) -> tuple[Any, Any]:
        """Return the decay factor over a duration [s] and the variance of the accumulated noise.

        Parameters
        ----------
        duration : float or array
            For an array, the results are arrays. If `sigma` differs between axes, the last axis of
            the array must broadcast with the three axes.
        """
        ratio = duration / self.correlation_time
        return np.exp(-ratio), -np.square(self.sigma) * np.expm1(-2.0 * ratio)


@dataclass(frozen=True)
class ScalarConstant:
    """Constant error with three nearly equal components, which represents a scalar as a 3-vector.

    Attributes
    ----------
    sigma : float
        Initial 1-sigma of each component.
    correlation : float
        Initial correlation of any two components. Their difference has a 1-sigma of
        √(2 (1 - correlation)) sigma.
    """

    sigma: float
    correlation: float = 0.9999


#: Model of a state: the initial 1-sigma of a constant, for all axes or per axis, or a process.
State = float | tuple[float, float, float] | GaussMarkov | ScalarConstant


def get_initial_sigma(state: State) -> float | tuple[float, float, float]:
    """Return the initial 1-sigma of a state, for all axes or per axis."""
    return state.sigma if isinstance(state, GaussMarkov | ScalarConstant) else state


@pydantic.dataclasses.dataclass(frozen=True)
class BiasSensitivity(Settings):
    """Dependence of a bias or misalignment on a housekeeping channel.

    The error changes by c (u - u₀) with the channel's value u. The coefficient c is a constant
    3-vector that the filter estimates.

    Examples
    --------
    >>> from mgeo_attitude import Gyro, Influence
    >>> list(Gyro(bias_sensitivities=(Influence("temp", 5e-4, "degC", 20.0),)).states())
    ['bias', 'bias_per_temp']
    """

    channel: str
    """name of the channel: of a channel of the scenario, or of a telemetry column"""
    initial_sigma: float = Field(gt=0.0)
    """1-sigma of the coefficient per axis: change of the error per unit of the channel, in the unit
    of the initial bias (deg/s, nT, or part of a unit vector) or, for a misalignment, in deg"""
    unit: str = "unit"
    """unit of the channel, for display"""
    reference: float = 0.0
    """value of the channel at which the error equals the initial error"""
    error: Literal["bias", "misalignment"] = "bias"
    """error that depends on the channel"""

    @property
    def state_name(self) -> str:
        """Name of the coefficient's state."""
        return f"{self.error}_per_{self.channel}"

    def coefficient_unit(self, error: Unit) -> Unit:
        """Return the unit of the coefficient for an error in a unit."""
        return Unit(f"{error.text} per {self.unit}", error.suffix, error.factor)


def apply_bias_sensitivities(
    sensitivities: Sequence[BiasSensitivity],
    errors: MutableMapping[str, Any],
    channel_deviations: Sequence[Any],
    multiply: Callable[[Any, Any], Any] = lambda value, coefficient: value * coefficient,
) -> MutableMapping[str, Any]:
    """Add the effect of housekeeping channels to the errors of an owner, in place.

    Parameters
    ----------
    influences : sequence of Influence
    errors : mapping
        States by name. The coefficients are removed, and the errors that depend on them change.
    channel_deviations : sequence
        u - u₀ of each influence, in a shape that broadcasts with the states.
    multiply : function
        Product of a value and a state.
    """
    for influence, value in zip(sensitivities, channel_deviations, strict=True):
        known, change = errors[influence.error], multiply(value, errors.pop(influence.state_name))
        if influence.error == "bias" or isinstance(known, Vec3):
            errors[influence.error] = known + change
        else:
            errors[influence.error] = partial(_rotate_twice, known, change)
    return errors


def _rotate_twice(last: Any, first: Any, vector: Any) -> Any:
    return rotate(last, rotate(first, vector))


def expand_per_axis(sigma: float | tuple[float, float, float]) -> tuple[float, float, float]:
    """Return one number per axis, where one number may stand for all axes."""
    return sigma if isinstance(sigma, tuple) else (sigma, sigma, sigma)


def select_nonzero(**sigmas: float) -> dict[str, State]:
    """Return the constants with a nonzero initial 1-sigma."""
    return {state: sigma for state, sigma in sigmas.items() if sigma}


Misalignment = Annotated[
    Degrees,
    Field(
        ge=0.0,
        description="initial misalignment, 1-sigma per axis; 0 omits the states: the sensor then "
        "defines the body axes",
    ),
]
ScaleFactor = Annotated[
    NonNegative,
    Field(description="initial scale-factor error, 1-sigma per axis; 0 omits the states"),
]
#: See `vector.shear`.
Nonorthogonality = Annotated[
    Degrees,
    Field(
        ge=0.0,
        description="initial non-orthogonality, half the deviation of two axes from a right angle, "
        "1-sigma; 0 omits the states",
    ),
]


def check_bias_sensitivities(
    sensitivities: Sequence[BiasSensitivity], states: Collection[str], kind: str
) -> None:
    """Raise InvalidValue if an influence is repeated or refers to an error that does not exist."""
    for i, influence in enumerate(sensitivities):
        none = f"no influence: {kind} has no {influence.error} that could depend on it"
        there = {influence.state_name, influence.error} <= set(states)
        expect(there, f"bias_sensitivities[{i}].channel", influence.channel, none)
    expect_unique(
        "bias_sensitivities[{}].channel", [influence.state_name for influence in sensitivities]
    )


def check_considered(considered: Sequence[str], states: Collection[str]) -> None:
    """Raise InvalidValue if a considered state is repeated or unknown."""
    expect_unique("considered[{}]", considered)
    for i, state in enumerate(considered):
        if state not in states:
            expected = f"unknown state{format_known_names(state, states)}"
            raise InvalidValue(f"considered[{i}]", state, expected)
