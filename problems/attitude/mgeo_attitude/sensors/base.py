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

#: Type variable for a gyro or a sensor.
Instrument = TypeVar("Instrument")

Boresight = Annotated[
    Direction, Field(description="boresight of the sensor, body axes (any length)")
]
#: Smallest angle between the boresight and a body at which a sensor is not blinded [deg].
Exclusion = Annotated[Degrees | None, Field(ge=0.0, lt=90.0)]


@dataclass(frozen=True)
class Sensor(Settings, ABC):
    """Base class for attitude sensors with measurements of one to three components.

    A subclass is a frozen dataclass whose fields are the parameters of the sensor. The filter
    requires `states`, `linearize_measurement` and `noise_sigmas`, and generates its kernel from
    `linearize_measurement`. Simulation and calibration also require the exact model
    `predict_measurement`.

    Examples
    --------
    >>> from pydantic.dataclasses import dataclass
    >>> from mgeo_attitude import Sensor
    >>> @dataclass(frozen=True)
    ... class Direction(Sensor):
    ...     kind = "direction"
    ...     def states(self):
    ...         return {"bias": 0.01}
    ...     def linearize_measurement(self, x, v):
    ...         return v + x.bias
    ...     def noise_sigmas(self):
    ...         return (1e-3,) * 3
    >>> Direction(name="beacon").states()
    {'bias': 0.01}
    """

    selector: ClassVar[str] = "kind"
    kind: ClassVar[str]
    #: Names of the states that are rotation vectors of `rotation.rotate`; all others are additive.
    rotations: ClassVar[tuple[str, ...]] = ()
    #: Name of the state that is a constant offset of the measurements.
    offset_state: ClassVar[str] = "bias"
    #: True if the sensor requires the geomagnetic field model.
    needs_field: ClassVar[bool] = True
    #: Names of the fields that are noise 1-sigmas.
    noise_parameters: ClassVar[tuple[str, ...]] = ()
    #: Units of the states for display and for keys in scenario files; a missing state has no unit.
    units: ClassVar[dict[str, Unit]] = {"misalignment": DEG, "latency": SECOND}
    #: Suffixes of the telemetry columns, which begin with the sensor's name and an underscore: the
    #: components of a vector, or q1 to q4 of the measured quaternion from GCRF to the body, scalar
    #: last. The column of a scalar sensor is the sensor's name alone.
    telemetry_suffixes: ClassVar[tuple[str, ...]] = ("x", "y", "z")
    #: True if measured vectors have unit length, so that their length in telemetry is ignored.
    has_unit_length: ClassVar[bool] = False
    #: Unit of the vector components in telemetry.
    telemetry_unit: ClassVar[Unit] = DIMENSIONLESS

    name: Identifier
    """name of the sensor, unique in the scenario; prefix of its error states in tables and
    columns"""
    sample_interval: Seconds | None = Field(default=None, gt=0.0, kw_only=True)
    """time between two measurements, a multiple of the filter's step; default: one measurement at
    every step"""
    considered: tuple[str, ...] = Field(default=(), kw_only=True)
    """error states that the filter considers but does not estimate (Schmidt-Kalman filter)"""
    bias_sensitivities: tuple[BiasSensitivity, ...] = Field(default=(), kw_only=True)
    """housekeeping channels, such as a temperature or a current, on which the bias or the
    misalignment depends"""
    initial_latency_s: Seconds = Field(default=0.0, ge=0.0, kw_only=True)
    """1-sigma of the unknown constant latency of the measurements; 0 to model no latency"""

    def __post_init__(self) -> None:
        check_considered(self.considered, self.states())
        check_bias_sensitivities(self.bias_sensitivities, self.states(), self.kind)
        expect(
            not self.initial_latency_s or "latency" in self.states(),
            "initial_latency_s",
            self.initial_latency_s,
            f"0, because kind = {self.kind!r} has no latency state",
        )

    def latency_states(self) -> dict[str, State]:
        """Return a dict with the uncertainty model of the latency.

        The only key is ``latency``. The dict is empty for a sensor without latency. The result of
        `states` of a subclass includes this dict.
        """
        return {"latency": ScalarConstant(self.initial_latency_s)} if self.initial_latency_s else {}

    def sensitivity_states(self) -> dict[str, State]:
        """Return a dict with the initial 1-sigma of each bias-sensitivity coefficient.

        The keys are the names of the error states, such as ``bias_per_temp``. The result of
        `states` of a subclass includes this dict.
        """
        return {
            each.state_name: each.initial_sigma
            / (self.telemetry_unit if each.error == "bias" else DEG).factor
            for each in self.bias_sensitivities
        }

    @abstractmethod
    def states(self) -> Mapping[str, State]:
        """Return a mapping from each error state of the sensor to its initial uncertainty.

        Each error state is a 3-vector.

        Returns
        -------
        mapping
            For a constant error, its initial 1-sigma, for all axes or per axis; for a time-varying
            error, its process. The state ``latency`` is not passed to `linearize_measurement` and
            `predict_measurement`, whose attitude and vectors already refer to the time of the
            measurement.
        """

    def list_environment_errors(self) -> tuple[str, ...]:
        """Return the names of the environment model errors that affect the sensor.

        The names are keys of `EnvironmentErrors.states`. Errors that the scenario models are
        attributes of the argument `x` of `linearize_measurement` and `predict_measurement`.
        """
        return ()

    @abstractmethod
    def linearize_measurement(self, x: Any, v: Vec3) -> Any:
        """Return the linearized measurement error for given attitude and sensor errors.

        The result must be linear in `x`, since the filter derives the measurement matrix from it.

        Parameters
        ----------
        x : namespace of Vec3
            ``x.theta`` is the attitude error [rad]. Further attributes are the sensor's `states`
            and the modeled errors of `list_environment_errors`. ``x.reference_change`` is the
            change of `v` in body axes due to latency. ``x.to_body`` rotates a vector from GCRS to
            body axes. ``x.auxiliary_vectors`` is the list of the columns of `auxiliary_vectors` in
            body axes, followed by the columns of the derivative with respect to the orbit error if
            it affects the sensor.
        v : Vec3
            The `inertial_vector` in body axes.

        Returns
        -------
        Vec3, or a tuple with one component per entry of `noise_sigmas`
        """

    def predict_measurement(self, x: Any, v: Any) -> Any:
        """Return the noise-free measurement predicted by the nonlinear sensor model.

        The derivative at zero errors is `linearize_measurement`. Implementations use only ``+ - *
        /`` and the functions of `rotation`, since they are evaluated on arrays and on second-order
        polynomials in the errors (`estimation.taylor`).

        Parameters
        ----------
        x : namespace
            The sensor's `states` and the modeled errors of `list_environment_errors`, shape (...,
            3). A state of `rotations` is an argument of `rotate`. ``x.to_body`` and
            ``x.auxiliary_vectors`` are as in `linearize_measurement`.
        v : array, shape (..., 3)
            The `inertial_vector` in body axes.

        Returns
        -------
        array, shape (..., 3), or a tuple of arrays that `innovation` compares

        Raises
        ------
        NotImplementedError
            If the subclass does not define an exact model.
        """
        raise NotImplementedError(
            f"{type(self).__name__} has no exact measurement model: define predict_measurement "
            "to simulate or calibrate the sensor"
        )

    def add_noise(self, measurement: Any, noise: Floats) -> Any:
        """Add noise to a noise-free measurement.

        Parameters
        ----------
        measurement : array or tuple
            Result of `predict_measurement`.
        noise : array, shape (..., m)
            Noise in the axes and unit of `linearize_measurement`.

        Returns
        -------
        array or tuple, in the format of `measurement`
        """
        return measurement + noise

    def innovation(self, measured: Any, predicted: Any) -> Any:
        """Return the difference between a measurement and its prediction.

        Sign and unit are those of `linearize_measurement`. The axes of the m components may differ
        from those of `linearize_measurement` if the noise is isotropic.

        Parameters
        ----------
        measured, predicted : array or tuple
            Results of `predict_measurement`, `measured` with noise.

        Returns
        -------
        array, shape (..., m)
        """
        return measured - predicted

    @abstractmethod
    def noise_sigmas(self) -> tuple[float, ...]:
        """Return the noise 1-sigma of each component of a measurement.

        The values are in the unit of the measurement.
        """

    def inertial_vector(self, environment: Environment) -> Floats | None:
        """Return the reference vector that the sensor measures, at each sample, in GCRS axes.

        Parameters
        ----------
        environment : Environment
            Satellite position, Sun direction and geomagnetic field at each sample.

        Returns
        -------
        array, shape (n_steps + 1, 3), or None
            None for a sensor without a reference vector, such as a star tracker.
        """
        return None

    def position_gradient(self, environment: Environment) -> Floats:
        """Return the derivative of the reference vector with respect to the satellite position.

        Only sensors that are affected by the orbit error must define it.

        Returns
        -------
        array, shape (n_steps + 1, 3, 3)
            GCRS axes, for positions in units of `POSITION_UNIT`.
        """
        raise NotImplementedError

    @property
    def n_auxiliary_vectors(self) -> int:
        """Number of vectors that the measurement model needs besides the reference vector."""
        return 0

    def auxiliary_vectors(self, environment: Environment) -> Floats:
        """Return the vectors that the measurement model needs besides the reference vector.

        Examples are the tangent vectors of a direction sensor and the albedo vector of a
        photodiode. Only sensors whose `n_auxiliary_vectors` is above zero implement the method.

        Returns
        -------
        array, shape (n_steps + 1, 3, n_auxiliary_vectors)
            GCRS axes.
        """
        raise NotImplementedError

    def list_visibility_cones(self) -> tuple[Cone, ...]:
        """Return the cones that must contain or exclude a direction while the sensor measures.

        Each cone is centered on a body axis. The direction is, for example, the direction of the
        Sun. A field of view is a cone that must contain the `inertial_vector`.
        """
        return ()

    def get_max_rate(self) -> float:
        """Return the largest body rate at which the sensor can measure [rad/s].

        The filter compares it with the body rate in the step before a measurement.
        """
        return math.inf

    def find_available_samples(self, environment: Environment) -> Bools | None:
        """Return True at the samples where the environment permits a measurement.

        A Sun sensor, for example, cannot measure in eclipse. Visibility cones and body rates are
        evaluated separately.

        Returns
        -------
        array of bool, shape (n_steps + 1,), or None
            None if every sample is available.
        """
        return None


def scale_noise(instrument: Instrument, factor: float) -> Instrument:
    """Return a copy of a gyro or sensor with all noise parameters multiplied by a factor."""

    def multiply(sigma: Any) -> Any:
        return tuple(map(multiply, sigma)) if isinstance(sigma, tuple) else factor * sigma

    names = instrument.noise_parameters  # type: ignore[attr-defined]
    changes = {name: multiply(getattr(instrument, name)) for name in names}
    return dataclasses.replace(instrument, **changes)  # type: ignore[type-var]
