"""What a sensor declares: the error states it adds and a linear measurement of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..fields import Validated, quantity
from ..vector import Vec3

if TYPE_CHECKING:
    from ..environment import Environment


@dataclass(frozen=True)
class Sensor(Validated, ABC):
    """A sensor that measures a 3-vector.

    A subclass is a frozen dataclass of parameters with four methods. Nothing else is needed for a
    sensor to enter the filter: the kernel is generated from `measure`.
    """

    kind: ClassVar[str]

    name: str = quantity(doc="name, unique in the suite; prefixes the sensor's states")

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
            The `reference` vector in body axes.
        """

    @abstractmethod
    def noise(self) -> tuple[float, float, float]:
        """Measurement noise, 1-sigma per axis, in the unit of the measurement."""

    def reference(self, environment: Environment) -> NDArray[np.float64] | None:
        """Vector it looks at, GCRS, shape (n_steps + 1, 3); None where `measure` uses none."""
        return None

    def field_of_view(self) -> tuple[tuple[float, float, float], float] | None:
        """Boresight in body axes (unit vector) and half-angle [rad] outside which the `reference`
        vector is not seen; None where it always is.
        """
        return None

    def available(self, environment: Environment) -> NDArray[np.bool_] | None:
        """Samples at which it can measure, shape (n_steps + 1,); None for all."""
        return None
