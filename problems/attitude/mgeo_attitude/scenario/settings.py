"""The small sections of a scenario: initial uncertainty, maneuvers, convergence, trace weights."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from ..fields import Quantity, Validated, checked, quantity
from ..sensors import Gyro, Sensor


@dataclass(frozen=True, kw_only=True)
class InitialUncertainty(Validated):
    """What is known of the attitude at the start; gyro and sensors carry that of their errors."""

    attitude_deg: float = quantity(
        5.0, unit="deg", low=0.0, high=180.0, open_low=True, doc="attitude error, 1-sigma per axis"
    )


@dataclass(frozen=True, kw_only=True)
class ManeuverLimits(Validated):
    """Bounds of the design vector."""

    count: int = quantity(3, low=1, doc="number of constant-rate maneuvers")
    max_rate_deg_s: float = quantity(
        1.0, unit="deg/s", low=0.0, open_low=True, doc="greatest body rate per axis"
    )
    max_duration: float = quantity(
        2000.0, unit="s", low=0.0, open_low=True, doc="greatest duration of one maneuver"
    )


@dataclass(frozen=True, kw_only=True)
class Convergence(Validated):
    """When the filter counts as converged, tested once all maneuvers are over."""

    window: float = quantity(
        300.0, unit="s", low=0.0, open_low=True, doc="window, a multiple of the step"
    )
    relative_decrease: float = quantity(
        0.01,
        low=0.0,
        high=1.0,
        open_low=True,
        open_high=True,
        doc="converged if the trace fell by less than this fraction over the window",
    )


class TraceWeights(Mapping[str, float]):
    """Weight of each state block in the trace, 1 where none is given; immutable and hashable.

    Parameters
    ----------
    weights : mapping
        Weight, >= 0, by the name of a state block (`state_blocks`).

    Raises
    ------
    InvalidValue, InvalidType
        For a negative or non-finite weight, or one that is no number.
    """

    __slots__ = ("_weights",)

    def __init__(self, weights: Mapping[str, float] | None = None) -> None:
        spec = Quantity(doc="weight of the block in the trace", low=0.0)
        self._weights: dict[str, float] = {
            block: checked(block, weight, float, spec) for block, weight in (weights or {}).items()
        }

    def __getitem__(self, block: str) -> float:
        return self._weights[block]

    def __iter__(self) -> Iterator[str]:
        return iter(self._weights)

    def __len__(self) -> int:
        return len(self._weights)

    def __hash__(self) -> int:
        return hash(frozenset(self._weights.items()))

    def __repr__(self) -> str:
        return f"TraceWeights({self._weights})"

    def of(self, blocks: Iterable[str]) -> tuple[float, ...]:
        """Weights of the given blocks, in their order."""
        return tuple(self._weights.get(block, 1.0) for block in blocks)


def state_blocks(gyro: Gyro, sensors: Iterable[Sensor]) -> tuple[str, ...]:
    """Names of the 3-vectors of the error state: ``attitude``, ``gyro.bias``, ``sun.bias``..."""
    return (
        "attitude",
        *(f"gyro.{state}" for state in gyro.states()),
        *(f"{sensor.name}.{state}" for sensor in sensors for state in sensor.states()),
    )
