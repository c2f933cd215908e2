"""What a sensor declares: the error states it adds, and what it measures."""

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
from mgeo_attitude.sensors.errors import (
    Alike,
    Influence,
    State,
    check_considered,
    check_influences,
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

#: A gyro or a sensor.
Noisy = TypeVar("Noisy")

Boresight = Annotated[Direction, Field(description="direction it looks in, body axes (any length)")]
#: Least angle of the boresight from what blinds a sensor.
Exclusion = Annotated[Degrees | None, Field(ge=0.0, lt=90.0)]


@dataclass(frozen=True)
class Sensor(Settings, ABC):
    """A sensor that measures a 3-vector, or what fewer numbers say.

    A subclass is a frozen dataclass of parameters. `states`, `measure` and `noise` are all that it
    takes to enter the filter: the kernel is generated from `measure`. A sensor that is simulated,
    or calibrated, also says what it reports, without approximation: `measured`.

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
    #: Those of its states that are rotations, for `rotation.rotate`; all others are sums.
    rotations: ClassVar[tuple[str, ...]] = ()
    #: Name of the state that is a constant offset of the readings.
    offset: ClassVar[str] = "bias"
    #: Whether it is of no use where the geomagnetic field is not known.
    needs_field: ClassVar[bool] = True
    #: Those of its parameters that are 1-sigmas of noise.
    noise_parameters: ClassVar[tuple[str, ...]] = ()
    #: Units of its states for people and scenario files; one that is left out has none.
    units: ClassVar[dict[str, Unit]] = {"misalignment": DEG, "delay": SECOND}
    #: Columns of telemetry are its name, an underscore, and these: those of a vector, or q1 to q4
    #: of a quaternion from GCRF to the body as the sensor has it, scalar last. A single number has
    #: the name alone.
    channels: ClassVar[tuple[str, ...]] = ("x", "y", "z")
    #: Whether the length of a vector in telemetry says nothing.
    unit_length: ClassVar[bool] = False
    #: Unit of a vector in telemetry.
    channel_unit: ClassVar[Unit] = DIMENSIONLESS

    name: Identifier
    """name, unique in the suite; prefixes the sensor's states"""
    sample_interval: Seconds | None = Field(default=None, gt=0.0, kw_only=True)
    """time between samples, a multiple of the filter's step; without it one in every step"""
    considered: tuple[str, ...] = Field(default=(), kw_only=True)
    """its states that are not estimated, but whose uncertainty counts (Schmidt-Kalman)"""
    influences: tuple[Influence, ...] = Field(default=(), kw_only=True)
    """channels that its bias or misalignment follows: a temperature, a current"""
    initial_delay_s: Seconds = Field(default=0.0, ge=0.0, kw_only=True)
    """unknown constant time by which its readings are older than their time, 1-sigma; 0 leaves the
    states out"""

    def __post_init__(self) -> None:
        check_considered(self.considered, self.states())
        check_influences(self.influences, self.states(), self.kind)
        expect(
            not self.initial_delay_s or "delay" in self.states(),
            "initial_delay_s",
            self.initial_delay_s,
            f"0: {self.kind} has no state of this name",
        )

    def delay(self) -> dict[str, State]:
        """The state of its `initial_delay_s`, if there is one, for its `states`."""
        return {"delay": Alike(self.initial_delay_s)} if self.initial_delay_s else {}

    def follows(self) -> dict[str, State]:
        """Return the states of its `influences`, for its `states`."""
        return {
            each.state: each.initial_sigma
            / (self.channel_unit if each.error == "bias" else DEG).factor
            for each in self.influences
        }

    @abstractmethod
    def states(self) -> Mapping[str, State]:
        """Error states it adds, 3-vectors.

        A constant has its initial 1-sigma, of each axis if they differ, an error that varies the
        process it is. A
        `delay` is not for `measure` and `measured`: attitude and vectors are given to them of the
        time at which the reading was taken.
        """

    def sees(self) -> tuple[str, ...]:
        """Errors of the world that it sees, of the names of `World.states`.

        Those that the world has are in `measure`'s and `measured`'s `x` as its own are.
        """
        return ()

    @abstractmethod
    def measure(self, x: Any, v: Vec3) -> Any:
        """Measurement error as a linear function of the error state: up to three numbers.

        Parameters
        ----------
        x : namespace of Vec3
            ``x.theta`` is the attitude error [rad], others are the sensor's own `states` and what
            it `sees`, where the world has it; ``x.moved`` is by how much `v` is another vector,
            body axes. ``x.to_body`` turns a GCRS vector into body axes; ``x.gradient`` are the
            columns of its `gradient` there, as `Vec3`, and then those of the derivative by the
            orbit's error, where it sees that.
        v : Vec3
            The `inertial_vector` in body axes.

        Returns
        -------
        Vec3, or a tuple of as many numbers as `noise` has
        """

    def measured(self, x: Any, v: Any) -> Any:
        """What it reports but for noise, whatever the size of the errors.

        Its derivative at zero is `measure`. Only ``+ - * /`` and the functions of `rotation` may be
        used: it is evaluated on arrays (truth and estimate) and on polynomials of second order in
        the errors (`estimation.taylor`).

        Parameters
        ----------
        x : namespace
            The sensor's own `states` and what it `sees`, shape (..., 3); one of `rotations` is an
            argument for `rotate`; and ``x.to_body`` and ``x.gradient``, see `measure`.
        v : array, shape (..., 3)
            The `inertial_vector` in body axes.

        Returns
        -------
        array, shape (..., 3), or whatever tuple of them `innovation` compares
        """
        raise NotImplementedError(
            f"{type(self).__name__} does not say what it measures: define `measured` to simulate it"
        )

    def with_noise(self, measured: Any, noise: Floats) -> Any:
        """What it reports with noise, shape (..., m) of `measure` and in its unit."""
        return measured + noise

    def innovation(self, measured: Any, predicted: Any) -> Any:
        """Difference of two results of `measured`, in the sense and unit of `measure`.

        Its m numbers may be along other axes than those of `measure` if noise is alike along all.
        """
        return measured - predicted

    @abstractmethod
    def noise(self) -> tuple[float, ...]:
        """Measurement noise, 1-sigma of each number, in the unit of the measurement."""

    def inertial_vector(self, environment: Environment) -> Floats | None:
        """Vector it looks at, GCRS, shape (n_steps + 1, 3); None where `measure` uses none."""
        return None

    def by_position(self, environment: Environment) -> Floats:
        """Derivative of the `inertial_vector` by the position, if it `sees` the orbit's error.

        Shape (n_steps + 1, 3, 3), GCRS, for a position in units of `POSITION_UNIT`.
        """
        raise NotImplementedError

    @property
    def n_gradient(self) -> int:
        """How many columns the `gradient` has that `measure` uses."""
        return 0

    def gradient(self, environment: Environment) -> Floats:
        """Derivative of the `inertial_vector` by whatever it is for.

        Shape (n_steps + 1, 3, n_gradient), GCRS.
        """
        raise NotImplementedError

    def views(self) -> tuple[Cone, ...]:
        """Cones about body axes that directions must be inside of, or outside, for it to measure.

        A field of view is a cone that its `inertial_vector` must be inside of.
        """
        return ()

    def max_rate(self) -> float:
        """Greatest body rate in the step before a sample at which it can measure [rad/s]."""
        return math.inf

    def available(self, environment: Environment) -> Bools | None:
        """Samples at which it can measure, if it sees, shape (n_steps + 1,); None for all."""
        return None


def with_noise(part: Noisy, factor: float) -> Noisy:
    """A gyro or sensor with its noise times a factor."""

    def times(sigma: Any) -> Any:
        return tuple(map(times, sigma)) if isinstance(sigma, tuple) else factor * sigma

    names = part.noise_parameters  # type: ignore[attr-defined]
    return dataclasses.replace(part, **{name: times(getattr(part, name)) for name in names})  # type: ignore[type-var]
