"""Error models of gyro, sensors and environment models, from which the error state is assembled.

A constant error has an initial 1-sigma. A time-varying error is a first-order Gauss-Markov process.
A bias or misalignment may depend on a housekeeping channel, such as a temperature or a current.
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
    """Stationary first-order Gauss-Markov (Ornstein-Uhlenbeck) process of a time-varying error.

    The error e follows e' = -e / τ + white noise with correlation time τ. Its autocorrelation after
    a time t is exp(-t / τ) (A. Gelb, Applied Optimal Estimation, 1974, section 2.2). In
    `Sensor.states`, the process replaces the initial 1-sigma of a constant.

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
        """Power spectral density of the driving white noise, for all axes or per axis."""
        return 2.0 * np.square(self.sigma) / self.correlation_time

    def discretize(self, duration: Any) -> tuple[Any, Any]:
        """Return the decay factor and the noise variance of the process over a duration.

        Parameters
        ----------
        duration : float or array
            Duration [s]. If `sigma` differs between axes, the last axis of an array must broadcast
            with the three axes.

        Returns
        -------
        decay, variance : float or array
            An error e becomes decay * e plus noise of this variance.
        """
        ratio = duration / self.correlation_time
        return np.exp(-ratio), -np.square(self.sigma) * np.expm1(-2.0 * ratio)


@dataclass(frozen=True)
class ScalarConstant:
    """Uncertainty model of a constant scalar error, such as a latency.

    The error states of the filter are 3-vectors. Three highly correlated components therefore
    represent the scalar.

    Attributes
    ----------
    sigma : float
        Initial 1-sigma of each component.
    correlation : float
        Initial correlation of any two components. Their difference has a 1-sigma of √(2 (1 -
        correlation)) sigma.
    """

    sigma: float
    correlation: float = 0.9999


#: Uncertainty model of an error state: the initial 1-sigma of a constant, for all axes or per axis,
#: or a process.
State = float | tuple[float, float, float] | GaussMarkov | ScalarConstant


def get_initial_sigma(state: State) -> float | tuple[float, float, float]:
    """Return the initial 1-sigma of an error state, for all axes or per axis."""
    return state.sigma if isinstance(state, GaussMarkov | ScalarConstant) else state


@pydantic.dataclasses.dataclass(frozen=True)
class BiasSensitivity(Settings):
    """Linear dependence of a bias or misalignment on a housekeeping channel.

    An example of a channel is a temperature. The error changes by c (u - u₀) with the channel's
    value u and the reference value u₀. The coefficient c is a constant 3-vector that the filter
    estimates.

    Examples
    --------
    >>> from mgeo_attitude import BiasSensitivity, Gyro
    >>> list(Gyro(bias_sensitivities=(BiasSensitivity("temp", 5e-4, "degC", 20.0),)).states())
    ['bias', 'bias_per_temp']
    """

    channel: str
    """name of the housekeeping channel in the scenario or of the column in the telemetry"""
    initial_sigma: float = Field(gt=0.0)
    """1-sigma of the coefficient per axis: change of the error per unit of the channel. Units of
    the error: deg/s for the gyro, nT for a magnetometer, 1 for the bias of a unit vector, deg for a
    misalignment"""
    unit: str = "unit"
    """unit of the channel, for display"""
    reference: float = 0.0
    """value of the channel at which the coefficient has no effect on the error"""
    error: Literal["bias", "misalignment"] = "bias"
    """error that depends on the channel"""

    @property
    def state_name(self) -> str:
        """Name of the error state that contains the coefficient, such as ``bias_per_temp``."""
        return f"{self.error}_per_{self.channel}"

    def coefficient_unit(self, error: Unit) -> Unit:
        """Return the unit of the coefficient for a given unit of the bias or misalignment.

        The unit is, for example, ``deg/h per degC``.
        """
        return Unit(f"{error.text} per {self.unit}", error.suffix, error.factor)


def apply_bias_sensitivities(
    sensitivities: Sequence[BiasSensitivity],
    errors: MutableMapping[str, Any],
    channel_deviations: Sequence[Any],
    multiply: Callable[[Any, Any], Any] = lambda value, coefficient: value * coefficient,
) -> MutableMapping[str, Any]:
    """Add the effect of housekeeping channels to bias and misalignment, in place.

    The effect is the product of a channel deviation and its coefficient.

    Parameters
    ----------
    sensitivities : sequence of BiasSensitivity
    errors : mapping
        Error states, keyed by name. The coefficients are removed, and the errors that depend on
        them change.
    channel_deviations : sequence
        Channel minus reference value of each sensitivity, in a shape that broadcasts with the
        states.
    multiply : function
        Product of a channel deviation and a coefficient.

    Returns
    -------
    mapping
        The argument `errors`.
    """
    for sensitivity, deviation in zip(sensitivities, channel_deviations, strict=True):
        error = errors[sensitivity.error]
        change = multiply(deviation, errors.pop(sensitivity.state_name))
        if sensitivity.error == "bias" or isinstance(error, Vec3):
            errors[sensitivity.error] = error + change
        else:
            errors[sensitivity.error] = partial(_rotate_twice, error, change)
    return errors


def _rotate_twice(last: Any, first: Any, vector: Any) -> Any:
    return rotate(last, rotate(first, vector))


def expand_per_axis(sigma: float | tuple[float, float, float]) -> tuple[float, float, float]:
    """Expand a single value to a tuple of three values, one per axis.

    A tuple is returned unchanged.
    """
    return sigma if isinstance(sigma, tuple) else (sigma, sigma, sigma)


def select_nonzero(**sigmas: float) -> dict[str, State]:
    """Return a dict of the error states whose initial 1-sigma is nonzero.

    The 1-sigmas are keyword arguments, such as ``bias=0.01``.
    """
    return {state: sigma for state, sigma in sigmas.items() if sigma}


Misalignment = Annotated[
    Degrees,
    Field(
        ge=0.0,
        description="initial misalignment between sensor and body axes, 1-sigma per axis; 0 to "
        "model no misalignment: the sensor then defines the body axes",
    ),
]
ScaleFactor = Annotated[
    NonNegative,
    Field(description="initial scale-factor error, 1-sigma per axis; 0 to model no error"),
]
#: Half the deviation of two axes from a right angle; see `vector.shear`.
Nonorthogonality = Annotated[
    Degrees,
    Field(
        ge=0.0,
        description="initial non-orthogonality, half the deviation of two axes from a right angle, "
        "1-sigma; 0 to model none",
    ),
]


def check_bias_sensitivities(
    sensitivities: Sequence[BiasSensitivity], states: Collection[str], kind: str
) -> None:
    """Raise InvalidValue if a bias sensitivity is repeated or refers to a missing error state.

    Parameters
    ----------
    sensitivities : sequence of BiasSensitivity
    states : collection of str
        Names of the error states of the gyro or sensor.
    kind : str
        Name of the device in the message.
    """
    for i, sensitivity in enumerate(sensitivities):
        exists = {sensitivity.state_name, sensitivity.error} <= set(states)
        expected = f"no bias sensitivity, because {kind} has no {sensitivity.error} state"
        expect(exists, f"bias_sensitivities[{i}].channel", sensitivity.channel, expected)
    expect_unique("bias_sensitivities[{}].channel", [each.state_name for each in sensitivities])


def check_considered(considered: Sequence[str], states: Collection[str]) -> None:
    """Raise InvalidValue if a considered state is repeated or is not an error state."""
    expect_unique("considered[{}]", considered)
    for i, state in enumerate(considered):
        if state not in states:
            expected = f"unknown state{format_known_names(state, states)}"
            raise InvalidValue(f"considered[{i}]", state, expected)
