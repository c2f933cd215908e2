"""Base class of sensors: error states, linearized and exact measurement models."""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, TypeVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.environment.directions import Cone
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.geometry.vector import Vec3
from mgeo_attitude.sensors.error_models import (
    BiasSensitivity,
    ScalarConstant,
    State,
    check_bias_sensitivities,
    check_considered,
)
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import expect
from mgeo_attitude.settings.types import (
    DEG,
    DIMENSIONLESS,
    SECOND,
    Degrees,
    Direction,
    Identifier,
    Seconds,
    Unit,
)

#: Gyro or sensor.
Instrument = TypeVar("Instrument")

Boresight = Annotated[Direction, Field(description="boresight, body axes (any length)")]
#: Least angle between the boresight and a body that blinds a sensor.
Exclusion = Annotated[Degrees | None, Field(ge=0.0, lt=90.0)]


@dataclass(frozen=True)
class Sensor(Settings, ABC):
    """A sensor that measures a 3-vector or up to three numbers.

    A subclass is a frozen dataclass of parameters. The filter requires `states`, `linearize_measurement` and
    `noise_sigmas`; its kernel is generated from `linearize_measurement`. Simulation and calibration also require the
    exact model `predict_measurement`.

    Examples
    --------
    >>> from pydantic.dataclasses import dataclass
    >>> from mgeo_attitude import Sensor
    >>> @dataclass(frozen=True)
    ... class Direction(Sensor):
    ...     kind = "direction"
    ...     def states(self):
    ...         return {"bias": 0.01}
    ...     def measure(self, x, v):
    ...         return v + x.bias
    ...     def noise(self):
    ...         return (1e-3,) * 3
    >>> Direction(name="beacon").states()
    {'bias': 0.01}
    """

    selector: ClassVar[str] = "kind"
    kind: ClassVar[str]
    #: States that are rotation vectors for `rotation.rotate`; all other states are additive.
    rotations: ClassVar[tuple[str, ...]] = ()
    #: Name of the state that is a constant offset of the measurements.
    offset_state: ClassVar[str] = "bias"
    #: Whether the sensor requires the geomagnetic field model.
    needs_field: ClassVar[bool] = True
    #: Names of the parameters that are 1-sigmas of noise.
    noise_parameters: ClassVar[tuple[str, ...]] = ()
    #: Display units of the states, also of keys in scenario files; missing states have no unit.
    units: ClassVar[dict[str, Unit]] = {"misalignment": DEG, "latency": SECOND}
    #: Suffixes of the telemetry columns, which follow the sensor's name and an underscore:
    #: components of a vector, or q1 to q4 of the measured quaternion from GCRF to the body, scalar
    #: last. The column of a scalar is the sensor's name alone.
    telemetry_suffixes: ClassVar[tuple[str, ...]] = ("x", "y", "z")
    #: Whether the length of a vector in telemetry is ignored.
    has_unit_length: ClassVar[bool] = False
    #: Unit of a vector in telemetry.
    telemetry_unit: ClassVar[Unit] = DIMENSIONLESS

    name: Identifier
    """name, unique in the suite; prefix of the sensor's states"""
    sample_interval: Seconds | None = Field(default=None, gt=0.0, kw_only=True)
    """time between measurements, a multiple of the filter's step; default: every step"""
    considered: tuple[str, ...] = Field(default=(), kw_only=True)
    """states that the filter considers but does not estimate (Schmidt-Kalman)"""
    bias_sensitivities: tuple[BiasSensitivity, ...] = Field(default=(), kw_only=True)
    """housekeeping channels on which the bias or misalignment depends, such as a temperature or a
    current"""
    initial_latency_s: Seconds = Field(default=0.0, ge=0.0, kw_only=True)
    """unknown constant latency of the measurements, 1-sigma; 0 omits the states"""

    def __post_init__(self) -> None:
        check_considered(self.considered, self.states())
        check_bias_sensitivities(self.bias_sensitivities, self.states(), self.kind)
        expect(
            not self.initial_latency_s or "latency" in self.states(),
            "initial_latency_s",
            self.initial_latency_s,
            f"0: {self.kind} has no state of this name",
        )

    def latency_states(self) -> dict[str, State]:
        """Return the state of `initial_latency_s`, if any, for use in `states`."""
        return {"latency": ScalarConstant(self.initial_latency_s)} if self.initial_latency_s else {}

    def sensitivity_states(self) -> dict[str, State]:
        """Return the states of `bias_sensitivities`, for use in `states`."""
        return {
            each.state_name: each.initial_sigma
            / (self.telemetry_unit if each.error == "bias" else DEG).factor
            for each in self.bias_sensitivities
        }

    @abstractmethod
    def states(self) -> Mapping[str, State]:
        """Return the error states of the sensor, each a 3-vector, by name.

        Returns
        -------
        mapping
            For a constant its initial 1-sigma, for all axes or per axis; for a time-varying error
            its process. The state ``delay`` is not passed to `measure` and `measured`, whose
            attitude and vectors already refer to the time of the measurement.
        """

    def list_environment_errors(self) -> tuple[str, ...]:
        """Return the names of the `World.states` that affect the sensor.

        The errors that the scenario models are attributes of the `x` of `measure` and `measured`.
        """
        return ()

    @abstractmethod
    def linearize_measurement(self, x: Any, v: Vec3) -> Any:
        """Return the measurement error as a linear function of the error state.

        Parameters
        ----------
        x : namespace of Vec3
            ``x.theta`` is the attitude error [rad]. Further attributes are the sensor's `states`
            and the modeled errors of `list_environment_errors`. ``x.reference_change`` is the change of `v` in body axes.
            ``x.to_body`` rotates a vector from GCRS to body axes. ``x.gradient`` holds the columns
            of `gradient` in body axes, followed by those of the derivative with respect to the
            orbit error, if the sensor is affected by it.
        v : Vec3
            The `inertial_vector` in body axes.

        Returns
        -------
        Vec3, or a tuple of as many numbers as `noise` has
        """

    def predict_measurement(self, x: Any, v: Any) -> Any:
        """Return the exact noise-free measurement for errors of any size.

        The derivative at zero errors is `measure`. Implementations use only ``+ - * /`` and the
        functions of `rotation`, since they are evaluated on arrays and on second-order polynomials
        in the errors (`estimation.taylor`).

        Parameters
        ----------
        x : namespace
            The sensor's `states` and the modeled errors of `list_environment_errors`, shape (..., 3); a state of
            `rotations` is an argument of `rotate`. ``x.to_body`` and ``x.gradient`` are as in
            `measure`.
        v : array, shape (..., 3)
            The `inertial_vector` in body axes.

        Returns
        -------
        array, shape (..., 3), or a tuple of arrays that `innovation` compares
        """
        raise NotImplementedError(
            f"{type(self).__name__} has no exact measurement model: define `measured` to simulate "
            "or calibrate the sensor"
        )

    def add_noise(self, measurement: Any, noise: Floats) -> Any:
        """Add noise to a measurement.

        Parameters
        ----------
        measurement : array or tuple
            Result of `measurement`.
        noise : array, shape (..., m)
            Noise in the axes and unit of `measure`.
        """
        return measurement + noise

    def innovation(self, measured: Any, predicted: Any) -> Any:
        """Return the difference of two results of `measured`, in the sign and unit of `measure`.

        The axes of the m numbers may differ from those of `measure` if the noise is isotropic.
        """
        return measured - predicted

    @abstractmethod
    def noise_sigmas(self) -> tuple[float, ...]:
        """Return the 1-sigma of the noise of each number, in the unit of the measurement."""

    def inertial_vector(self, environment: Environment) -> Floats | None:
        """Return the reference vector in GCRS, shape (n_steps + 1, 3), or None."""
        return None

    def position_gradient(self, environment: Environment) -> Floats:
        """Return the derivative of the `inertial_vector` with respect to the position.

        Required for sensors that are affected by the orbit error.

        Returns
        -------
        array, shape (n_steps + 1, 3, 3)
            GCRS axes, for positions in units of `POSITION_UNIT`.
        """
        raise NotImplementedError

    @property
    def n_gradient(self) -> int:
        """Number of columns of `gradient` that `measure` uses."""
        return 0

    def gradient(self, environment: Environment) -> Floats:
        """Return additional vectors for `measure`, such as derivatives of the `inertial_vector`.

        Returns
        -------
        array, shape (n_steps + 1, 3, n_gradient)
            GCRS axes.
        """
        raise NotImplementedError

    def list_visibility_cones(self) -> tuple[Cone, ...]:
        """Return the cones that must contain or exclude directions for a measurement.

        A field of view is a cone that must contain the `inertial_vector`.
        """
        return ()

    def max_rate(self) -> float:
        """Return the largest body rate in the step before a measurement [rad/s]."""
        return math.inf

    def find_available_samples(self, environment: Environment) -> Bools | None:
        """Return a mask of the samples at which the environment permits a measurement.

        The shape is (n_steps + 1,); None stands for all samples. Cones and rates are evaluated
        separately.
        """
        return None


def scale_noise(instrument: Instrument, factor: float) -> Instrument:
    """Return a gyro or sensor with its noise multiplied by a factor."""

    def times(sigma: Any) -> Any:
        return tuple(map(times, sigma)) if isinstance(sigma, tuple) else factor * sigma

    names = instrument.noise_parameters  # type: ignore[attr-defined]
    changes = {name: times(getattr(instrument, name)) for name in names}
    return dataclasses.replace(instrument, **changes)  # type: ignore[type-var]
