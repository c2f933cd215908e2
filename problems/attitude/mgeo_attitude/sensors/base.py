"""What a sensor declares: the error states it adds, and what it measures."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.environment.directions import Cone
from mgeo_attitude.fields import Validated, quantity
from mgeo_attitude.units import DIMENSIONLESS, Unit
from mgeo_attitude.vector import Vec3

if TYPE_CHECKING:
    from mgeo_attitude.environment import Environment

NAME = "name, unique in the suite; prefixes the sensor's states"


@dataclass(frozen=True)
class Sensor(Validated, ABC):
    """A sensor that measures a 3-vector.

    A subclass is a frozen dataclass of parameters. `states`, `measure` and `noise` are all that it
    takes to enter the filter: the kernel is generated from `measure`. A sensor that is simulated,
    or calibrated, also says what it reports, without approximation: `measured`.
    """

    kind: ClassVar[str]
    #: Those of its states that are rotations, for `rotation.rotate`; all others are sums.
    rotations: ClassVar[tuple[str, ...]] = ()
    #: Units of its states for people and scenario files; one that is left out has none.
    units: ClassVar[Mapping[str, Unit]] = {}
    #: Columns of telemetry are its name, an underscore, and these: those of a vector, or q1 to q4
    #: of a quaternion from GCRF to the sensor, scalar last.
    channels: ClassVar[tuple[str, ...]] = ("x", "y", "z")
    #: Unit of a vector in telemetry.
    channel_unit: ClassVar[Unit] = DIMENSIONLESS

    name: str = quantity(doc=NAME)

    @abstractmethod
    def states(self) -> dict[str, float]:
        """Error states it adds (3-vectors, body axes) with their initial 1-sigma per axis."""

    @abstractmethod
    def measure(self, x: Any, v: Vec3) -> Vec3:
        """Measurement error as a linear function of the error state.

        Parameters
        ----------
        x : namespace of Vec3
            ``x.theta`` is the attitude error [rad], the other attributes are the sensor's own
            `states`.
        v : Vec3
            The `inertial_vector` in body axes.
        """

    def measured(self, x: Any, v: Any) -> Any:
        """What it reports but for noise, whatever the size of the errors.

        Its derivative at zero is `measure`. Only ``+ - * /`` and the functions of `rotation` may be
        used: it is evaluated on arrays (truth and estimate) and on polynomials of second order in
        the errors (`estimation.taylor`).

        Parameters
        ----------
        x : namespace
            The sensor's own `states`, shape (..., 3); one of `rotations` is an argument for
            `rotate`; and ``x.to_body``, which turns a GCRS vector into body axes.
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
        """What it reports with noise, shape (..., 3) in the unit of `measure`."""
        return measured + noise

    def innovation(self, measured: Any, predicted: Any) -> Any:
        """Difference of two results of `measured`, in the sense and unit of `measure`."""
        return measured - predicted

    @abstractmethod
    def noise(self) -> tuple[float, float, float]:
        """Measurement noise, 1-sigma per axis, in the unit of the measurement."""

    def inertial_vector(self, environment: Environment) -> Floats | None:
        """Vector it looks at, GCRS, shape (n_steps + 1, 3); None where `measure` uses none."""
        return None

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
