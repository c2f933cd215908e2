"""The small sections of a scenario: maneuvers, convergence, trace weights."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from mgeo_attitude.fields import InvalidValue, Validated, expect, known_names, positive, quantity
from mgeo_attitude.sensors import GaussMarkov, Gyro, Sensor
from mgeo_attitude.units import DEG, DIMENSIONLESS, Unit


@dataclass(frozen=True, kw_only=True)
class ManeuverLimits(Validated):
    """Bounds of the design vector."""

    count: int = quantity(3, low=1, high=100, doc="number of constant-rate maneuvers")
    max_rate_deg_s: float = positive(1.0, unit="deg/s", doc="greatest body rate per axis")
    max_duration: float = positive(2000.0, unit="s", doc="greatest duration of one maneuver")
    max_acceleration_deg_s2: float | None = positive(
        None,
        unit="deg/s²",
        doc="greatest angular acceleration per axis; without it rates change at once",
    )
    slew_back: bool = quantity(
        False, doc="whether a plan ends, after t_end, with a slew back to the attitude of [initial]"
    )


@dataclass(frozen=True, kw_only=True)
class Convergence(Validated):
    """When the filter counts as converged, but not before all maneuvers are over."""

    rule: str = quantity(
        "trace",
        choices=("trace", "required", "settling"),
        doc="what tells: the trace over a window; from when on required_sigma is met until the end "
        "of duration; or from when on the trace stays within a factor of what it is then",
    )
    factor: float = quantity(1.25, low=1.0, open_low=True, doc="that factor, for the rule settling")
    window: float = positive(300.0, unit="s", doc="window, a multiple of the step")
    relative_decrease: float = quantity(
        0.01,
        low=0.0,
        high=1.0,
        open_low=True,
        open_high=True,
        doc="converged if the trace fell by less than this fraction over the window, and did not "
        "rise",
    )
    allow_rise: bool = quantity(
        False, doc="whether a trace that rose over the window counts as converged too"
    )


class Numbers(Mapping[str, float]):
    """Numbers by names with dots, such as ``mag.bias``; immutable and hashable."""

    def __init__(self, values: Mapping[str, float] | None = None) -> None:
        self._values = dict(values or {})

    def __getitem__(self, name: str) -> float:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __hash__(self) -> int:
        return hash(frozenset(self._values.items()))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._values})"


class TraceWeights(Numbers):
    """Weight, >= 0, of each state block in the trace.

    Where none is given it is 1, but 0 for errors that no plan makes smaller: `uncalibrated`.
    """

    def of(self, blocks: Iterable[str], uncalibrated: Collection[str] = ()) -> tuple[float, ...]:
        """Weights of the given blocks, in their order."""
        return tuple(self.get(block, 0.0 if block in uncalibrated else 1.0) for block in blocks)


class RequiredSigma(Numbers):
    """1-sigma, > 0, that a plan must reach in every axis of a state block.

    Keys end in the block's unit (`state_units`), in which the number is: ``attitude_deg``,
    ``gyro.bias_deg_h``, ``mag.bias_nt``; ``sun.bias``, parts of a unit vector, has none.
    """

    def of(self, units: Mapping[str, Unit]) -> tuple[float, ...]:
        """Requirements of blocks of these units, in the filter's; infinite where there is none."""
        return tuple(
            self.get(unit.key(block), math.inf) / unit.key_factor for block, unit in units.items()
        )


def state_units(gyro: Gyro, sensors: Iterable[Sensor]) -> dict[str, Unit]:
    """Unit of each 3-vector of the error state for people and scenario files, by its name."""
    owners: dict[str, Gyro | Sensor] = {"gyro": gyro} | {sensor.name: sensor for sensor in sensors}
    units = {
        f"{name}.{state}": owner.units.get(state, DIMENSIONLESS)
        for name, owner in owners.items()
        for state in owner.states()
    }
    varying, own = processes(owners.values()), [f"gyro.{state}" for state in gyro.states()]
    first = {block: units[block] for block in (*own, *varying)}  # the filter has them before others
    return {"attitude": DEG} | first | units


def processes(owners: Iterable[Gyro | Sensor]) -> dict[str, GaussMarkov]:
    """States of sensors that are Gauss-Markov processes, by the names of their blocks."""
    return {
        f"{owner.name}.{state}": value
        for owner in owners
        if isinstance(owner, Sensor)
        for state, value in owner.states().items()
        if isinstance(value, GaussMarkov)
    }


def considered_blocks(gyro: Gyro, sensors: Iterable[Sensor]) -> tuple[str, ...]:
    """Blocks of the state that are considered, not estimated."""
    own = [f"gyro.{state}" for state in gyro.considered]
    return (*own, *(f"{each.name}.{state}" for each in sensors for state in each.considered))


def uncalibrated(gyro: Gyro, sensors: Sequence[Sensor]) -> frozenset[str]:
    """Blocks of the state that no plan makes smaller for good: they vary, or are considered."""
    return frozenset((*processes(sensors), *considered_blocks(gyro, sensors)))


def check_blocks(key: str, values: Mapping[str, float], known: Collection[str]) -> None:
    """Refuse, with an InvalidValue, a number for a block that is not among the `known`."""
    for block, value in values.items():
        if block not in known:
            expected = f"unknown state block{known_names(block, known)}"
            raise InvalidValue(f"{key}.{block}", value, expected)


def check_name(name: str) -> None:
    """Refuse, with an InvalidValue, a ``name`` that would not fit a line of text."""
    sound = name.isprintable() and name.strip()
    expect(sound, "name", name, "printable characters on one line")
