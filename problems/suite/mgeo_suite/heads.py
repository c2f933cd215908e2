"""Sensors as a catalog offers them: Sun sensors of one face."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from mgeo_attitude import SunSensor
from mgeo_attitude.fields import quantity
from mgeo_attitude.geometry.vector import Vec3

#: Outward normals of the faces of a satellite, body axes.
FACES: dict[str, tuple[float, float, float]] = {
    "+x": (1.0, 0.0, 0.0),
    "-x": (-1.0, 0.0, 0.0),
    "+y": (0.0, 1.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "+z": (0.0, 0.0, 1.0),
    "-z": (0.0, 0.0, -1.0),
}


@dataclass(frozen=True)
class SunHead(SunSensor):
    """A Sun sensor on a face, whose bias states can be left out.

    Within the cone that a head sees, a bias of the vector can hardly be told from a misalignment:
    one of them is enough.
    """

    initial_bias: float = quantity(
        0.0,
        low=0.0,
        doc="initial bias of the unit vector, 1-sigma per axis; 0 leaves the states out",
        formerly="bias",
    )

    def states(self) -> dict[str, Any]:
        found = super().states()
        return {key: found[key] for key in found if key != "bias" or self.initial_bias}

    def measure(self, x: Any, v: Vec3) -> Any:
        return super().measure(self._complete(x, Vec3(0.0, 0.0, 0.0)), v)

    def measured(self, x: Any, v: Any) -> Any:
        return super().measured(self._complete(x, 0.0), v)

    def _complete(self, x: Any, zero: Any) -> Any:
        return x if self.initial_bias else SimpleNamespace(**{**vars(x), "bias": zero})
