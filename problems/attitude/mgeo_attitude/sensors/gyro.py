"""Gyro error model of equation (2): white rate noise and a random-walk or Gauss-Markov bias."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.rotation import rotate, shear, unrotate
from mgeo_attitude.geometry.vector import Vec3, componentwise_product, cross
from mgeo_attitude.geometry.vector import shear as shear_components
from mgeo_attitude.sensors.error_models import (
    BiasSensitivity,
    Nonorthogonality,
    ScaleFactor,
    check_bias_sensitivities,
    check_considered,
    expand_per_axis,
)
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import expect
from mgeo_attitude.settings.types import (
    DEG,
    DEG_H,
    PPM,
    Degrees,
    DegreesPerSecond,
    NonNegative,
    PerAxis,
    Positive,
    Unit,
    UsualRange,
)

#: Largest Allan deviation of a Gauss-Markov process, in units of q √T.
_ALLAN_PEAK = 0.437


@dataclass(frozen=True)
class Gyro(Settings):
    """Three-axis gyro with white rate noise and a time-varying bias.

    The bias follows a random walk or a Gauss-Markov process. The measured rate is ω_m = ω + b + v_g
    with body rate ω, bias b and noise v_g. Errors of scale factor, misalignment and
    non-orthogonality are optional; see `predict_measurement`.

    Examples
    --------
    >>> from mgeo_attitude import Gyro
    >>> Gyro(angle_random_walk_deg_per_sqrt_h=0.15, initial_scale_factor=1e-3).states()
    {'bias': 0.00017453292519943296, 'scale_factor': 0.001}
    """

    #: See `Sensor.noise_parameters`.
    noise_parameters: ClassVar[tuple[str, ...]] = ("angle_random_walk_deg_per_sqrt_h",)
    #: See `Sensor.rotations`.
    rotations: ClassVar[tuple[str, ...]] = ("misalignment",)
    #: See `Sensor.units`.
    units: ClassVar[Mapping[str, Unit]] = {
        "bias": DEG_H,
        "scale_factor": PPM,
        "misalignment": DEG,
        "nonorthogonality": DEG,
    }

    angle_random_walk_deg_per_sqrt_h: Annotated[
        PerAxis[Positive], Unit("deg/sqrt(h)"), UsualRange(5e-5, 5.0)
    ] = 0.01
    """angle random walk, one number for all axes or one per axis"""
    rate_random_walk: Annotated[PerAxis[NonNegative], Unit("rad/s^1.5")] = 3e-8
    """rate random walk of the bias, one number for all axes or one per axis"""
    bias_instability_deg_per_h: Annotated[
        PerAxis[Positive] | None, Unit("deg/h"), UsualRange(1e-4, 100.0)
    ] = None
    """bias instability, the maximum of the Allan deviation of the bias process, one number for all
    axes or one per axis; replaces rate_random_walk and requires bias_decay"""
    bias_decay: Annotated[float, Unit("1/s")] = Field(default=0.0, ge=0.0)
    """inverse correlation time of the bias; 0 for a random walk"""
    initial_bias_deg_s: DegreesPerSecond = Field(default=0.01, gt=0.0)
    """initial bias, 1-sigma per axis"""
    initial_scale_factor: ScaleFactor = 0.0
    initial_misalignment_deg: Degrees = Field(default=0.0, ge=0.0)
    """initial misalignment between gyro and body axes, 1-sigma per axis; 0 to model no
    misalignment"""
    initial_nonorthogonality_deg: Nonorthogonality = 0.0
    range_deg_per_s: DegreesPerSecond | None = Field(default=None, gt=0.0)
    """largest rate about an axis that the gyro can measure; an upper bound on the rates of plans"""
    quantization_deg_per_s: DegreesPerSecond | None = Field(default=None, gt=0.0)
    """quantization step of the measured rates, for simulation and calibration"""
    sample_noise_deg_s: Annotated[
        PerAxis[Positive] | None, Unit("deg/s"), UsualRange(1e-5, 5.0)
    ] = None
    """noise of each rate sample in addition to the angle random walk, 1-sigma, one number for all
    axes or one per axis; independent of the sample interval"""
    considered: tuple[str, ...] = ()
    """error states that the filter considers but does not estimate (Schmidt-Kalman filter)"""
    bias_sensitivities: tuple[BiasSensitivity, ...] = ()
    """housekeeping channels, such as a temperature or a current, on which the bias depends"""

    def __post_init__(self) -> None:
        floor = self.bias_instability_deg_per_h
        expected = (
            "bias_decay > 0 in the same table, the inverse correlation time of the bias in 1/s; or "
            "rate_random_walk in place of bias_instability_deg_per_h"
        )
        expect(not floor or self.bias_decay, "bias_instability_deg_per_h", floor, expected)
        walk = expand_per_axis(self.rate_random_walk)
        expect(all(walk) == any(walk), "rate_random_walk", walk, "all > 0 rad/s^1.5, or all zero")
        check_considered(self.considered, self.states())
        check_bias_sensitivities(self.bias_sensitivities, self.states(), "the gyro")

    def states(self) -> dict[str, float]:
        """Return a dict with the initial 1-sigma of each error state of the gyro.

        Every state is a 3-vector in body axes. The units are rad/s for the bias, rad for
        misalignment and non-orthogonality, and 1 for the scale factor.
        """
        states = {
            "bias": math.radians(self.initial_bias_deg_s),
            "scale_factor": self.initial_scale_factor,
            "misalignment": math.radians(self.initial_misalignment_deg),
            "nonorthogonality": math.radians(self.initial_nonorthogonality_deg),
            **{
                each.state_name: math.radians(each.initial_sigma)
                for each in self.bias_sensitivities
                if each.error == "bias"
            },
        }
        return {state: sigma for state, sigma in states.items() if sigma}

    def convert_sample_noise(self, interval: float) -> Gyro:
        """Return a copy of the gyro in which the angle random walk includes the sample noise.

        Independent rate errors of 1-sigma σ at a sample interval T accumulate to an angle random
        walk of σ √T.

        Parameters
        ----------
        interval : float
            Sample interval T [s].
        """
        if self.sample_noise_deg_s is None:
            return self
        walks = expand_per_axis(self.angle_random_walk_deg_per_sqrt_h)
        pairs = zip(walks, expand_per_axis(self.sample_noise_deg_s), strict=True)
        x, y, z = (math.hypot(walk, 60.0 * sigma * math.sqrt(interval)) for walk, sigma in pairs)
        return dataclasses.replace(
            self, angle_random_walk_deg_per_sqrt_h=(x, y, z), sample_noise_deg_s=None
        )

    def compute_error_derivative(self, x: Any, omega: Vec3) -> dict[str, Vec3]:
        """Return the time derivatives of the attitude error and of the gyro's error states.

        The keys of the dict are the names of the states. This is equation (2) without noise. States
        that are missing from the result are constant. Channel deviations of `bias_sensitivities`
        are taken as one.

        Parameters
        ----------
        x : namespace of Vec3
            ``x.theta``, the attitude error [rad], and the gyro's `states`.
        omega : Vec3
            Body rate [rad/s].
        """
        theta = -cross(omega, x.theta) - x.bias
        if self.initial_scale_factor:
            theta = theta - componentwise_product(omega, x.scale_factor)
        if self.initial_misalignment_deg:
            theta = theta + cross(omega, x.misalignment)
        if self.initial_nonorthogonality_deg:
            theta = theta - shear_components(omega, x.nonorthogonality)
        for sensitivity in self.bias_sensitivities:
            theta = theta - getattr(x, sensitivity.state_name)
        return {"theta": theta, "bias": -self.bias_decay * x.bias}

    def predict_measurement(self, x: Any, omega: Floats) -> Floats:
        """Return the noise-free rate predicted by the nonlinear gyro model.

        ω_m = R(μ) (ω + k ∘ ω + N(η) ω) + b, with misalignment μ, scale factors k and the symmetric
        matrix N of the non-orthogonality η (`vector.shear`).

        Parameters
        ----------
        x : namespace of arrays, shape (..., 3)
            The gyro's `states`.
        omega : array, shape (..., 3)
            Body rate ω [rad/s].

        Returns
        -------
        array, shape (..., 3)
            Measured rate ω_m [rad/s].
        """
        rate = self._apply_scale_and_shear(x, omega)
        if self.initial_misalignment_deg:
            rate = rotate(x.misalignment, rate)
        measured: Floats = rate + x.bias
        return measured

    def correct_measurement(self, x: Any, measured: Floats) -> Floats:
        """Correct a measured rate for given error states of the gyro.

        This is the inverse of `predict_measurement`.

        Parameters
        ----------
        x : namespace of arrays, shape (..., 3)
            The gyro's `states`.
        measured : array, shape (..., 3)
            Measured rate [rad/s].

        Returns
        -------
        array, shape (..., 3)
            Body rate [rad/s].
        """
        rate: Any = measured - x.bias
        if self.initial_misalignment_deg:
            rate = unrotate(x.misalignment, rate)
        if self.initial_nonorthogonality_deg:
            columns = np.stack(
                [self._apply_scale_and_shear(x, axis) for axis in np.eye(3)], axis=-1
            )
            if columns.size == 9:  # The errors are equal for all rates.
                rate = np.einsum("ij,...j->...i", np.linalg.inv(columns.reshape(3, 3)), rate)
            else:
                rate = np.linalg.solve(columns, rate[..., None])[..., 0]
        elif self.initial_scale_factor:
            rate = rate / (1.0 + x.scale_factor)
        corrected: Floats = rate
        return corrected

    def _apply_scale_and_shear(self, x: Any, rate: Floats) -> Floats:
        """Apply the scale-factor and non-orthogonality errors of the gyro to a body rate.

        This is (I + diag(k) + N(η)) ω for the scale factors k and the non-orthogonality η.
        """
        scaled = rate
        if self.initial_scale_factor:
            scaled = scaled + x.scale_factor * rate
        if self.initial_nonorthogonality_deg:
            scaled = scaled + shear(x.nonorthogonality, rate)
        return scaled

    @property
    def effective_rate_random_walk(self) -> tuple[float, float, float]:
        """Rate random walk of the bias per axis [rad/s^1.5].

        The value is given directly or derived from the bias instability. The bias instability is
        the maximum of the Allan deviation of a Gauss-Markov process with driving noise q and
        correlation time T: 0.437 q √T, at 1.89 T (IEEE Std 952-1997, annex C.1.5).
        """
        if self.bias_instability_deg_per_h is None:
            return expand_per_axis(self.rate_random_walk)
        x, y, z = (
            math.radians(floor) / 3600.0 * math.sqrt(self.bias_decay) / _ALLAN_PEAK
            for floor in expand_per_axis(self.bias_instability_deg_per_h)
        )
        return x, y, z

    def compute_noise_density(self) -> dict[str, list[float]]:
        """Return the power spectral densities of the angle and rate random walks, per axis.

        Returns
        -------
        dict of str to list of float
            Densities per axis, with the keys ``theta`` [rad²/s] and ``bias`` [rad²/s³].
        """
        walks = expand_per_axis(self.angle_random_walk_deg_per_sqrt_h)
        return {
            "theta": [(math.radians(walk) / 60.0) ** 2 for walk in walks],
            "bias": [drift**2 for drift in self.effective_rate_random_walk],
        }


def has_axis_dependent_noise(noise_density: Floats) -> bool:
    """Return True if the noise of a gyro differs between the three axes.

    Parameters
    ----------
    noise_density : array, shape (..., n), n >= 6
        Diagonal of the process noise density, with attitude error and gyro bias first; see
        `Suite.compute_noise_density`.
    """
    walks = noise_density[..., :6].reshape(*noise_density.shape[:-1], 2, 3)
    return bool(np.ptp(walks, axis=-1).any())
