"""What plans are judged by: when they end, objectives, required 1-sigmas, Monte Carlo runs.

`criteria` computes objectives and constraints.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BeforeValidator, Field, GetCoreSchemaHandler
from pydantic.dataclasses import dataclass
from pydantic_core import CoreSchema

from mgeo_attitude.criteria.objectives import OBJECTIVES, TRACE_OF, blocks_of
from mgeo_attitude.settings.base import Settings, flatten
from mgeo_attitude.settings.errors import InvalidValue, expect, expect_unique, known_names
from mgeo_attitude.settings.types import (
    Degrees,
    DegreesPerSecond,
    NonNegative,
    Positive,
    Seconds,
    Unit,
)


@dataclass(frozen=True, kw_only=True)
class Convergence(Settings):
    """When a plan ends: with its last maneuver, or later, once the filter has converged.

    Examples
    --------
    >>> from mgeo_attitude.scenario import Convergence
    >>> Convergence(rule="end").rule
    'end'
    """

    rule: Literal["trace", "required", "settling", "end"] = "trace"
    """what tells: the trace over a window; from when on required_sigma is met until the end of
    duration; from when on the trace stays within a factor of what it is then; or the end of the
    last maneuver alone"""
    factor: float = Field(default=1.25, gt=1.0)
    """that factor, for the rule settling"""
    window: Seconds = Field(default=300.0, gt=0.0)
    """window, a multiple of the step"""
    relative_decrease: float = Field(default=0.01, gt=0.0, lt=1.0)
    """converged if the trace fell by less than this fraction over the window, and did not rise"""
    allow_rise: bool = False
    """whether a trace that rose over the window counts as converged too"""

    @property
    def time(self) -> str:
        """What t_end is, in words."""
        return "a plan's end" if self.rule == "end" else "time to converge"


@dataclass(frozen=True, kw_only=True)
class FlightErrors(Settings):
    """Flights over which a plan is judged, each with errors drawn from these.

    Flight k of a seed is the same however many others there are.

    Examples
    --------
    >>> from mgeo_attitude.scenario import FlightErrors
    >>> FlightErrors(count=32, attitude_deg=5.0, rate_error_deg_s=0.01).quantile
    0.9
    """

    count: int = Field(default=16, ge=1, le=10_000)
    """number of flights, the same for all plans"""
    seed: int = Field(default=0, ge=0)
    """seed of what is drawn"""
    quantile: float = Field(default=0.9, gt=0.0, le=1.0)
    """share of the flights that must keep the value of an objective; 1 for the worst"""
    mean: bool = False
    """whether objectives are means over the flights instead"""
    kept: float = Field(default=1.0, gt=0.0, le=1.0)
    """share of the flights that must keep each limit"""
    grow: tuple[Annotated[int, Field(ge=0, le=10_000)], ...] = ()
    """how many there are in the stages of a search before its last; 0 for none but the exact one"""
    attitude_deg: Degrees | None = Field(default=None, ge=0.0, le=180.0)
    """attitude error at the start, 1-sigma per axis; initial.attitude_deg if not given"""
    rate_error_deg_s: DegreesPerSecond | None = Field(default=None, ge=0.0)
    """error of all rates, 1-sigma per axis; the gyro's initial bias if not given"""
    maneuver_rate_error_deg_s: DegreesPerSecond = Field(default=0.0, ge=0.0)
    """error of the rate of each maneuver, 1-sigma per axis"""
    duration_error: Seconds = Field(default=0.0, ge=0.0)
    """error of the duration of each maneuver, 1-sigma"""
    start_delay: Seconds = Field(default=0.0, ge=0.0, le=31 * 86400.0)
    """greatest delay of the start, of which all are equally likely; 604800 for a plan that holds at
    any time of a week"""

    noise_spread: float = Field(default=0.0, ge=0.0, le=2.0)
    """by how much the noise of the gyro and of each sensor may be other than is believed: 1-sigma
    of the logarithm of their ratio"""

    def __post_init__(self) -> None:
        counts = [*self.grow, self.count]
        expect(counts == sorted(counts), "grow", self.grow, f"ascending, up to {self.count}")

    def in_stage(self, stage: int | None) -> int:
        """Number of flights in a stage of a search, from 0; all after the last, or if None."""
        counts = [*self.grow, self.count]
        return self.count if stage is None else counts[min(stage, len(counts) - 1)]


class Numbers(dict[str, float]):
    """Numbers by names with dots, such as ``mag.bias``; hashable, as the scenario is.

    A table may nest them: ``{"mag": {"bias": 1.0}}``.
    """

    #: Range of the numbers.
    number: ClassVar[Any] = float

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(frozenset(self.items()))

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        nested = dict[str, cls.number | dict[str, cls.number]]  # type: ignore[name-defined]
        flat = Annotated[
            dict[str, cls.number],  # type: ignore[name-defined]
            BeforeValidator(flatten, json_schema_input_type=nested),
            AfterValidator(cls),
        ]
        return handler.generate_schema(flat)


class TraceWeights(Numbers):
    """Weight, >= 0, of each state block in the trace.

    Where none is given it is 1, but 0 for errors that no plan makes smaller: `uncalibrated`.

    Parameters
    ----------
    values : mapping of str to float, optional
        By names of blocks.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> scenario = Scenario.from_dict({"preset": "paper", "trace_weights": {"attitude": 10.0}})
    >>> dict(scenario.trace_weights)
    {'attitude': 10.0}
    """

    number = NonNegative

    def of(self, blocks: Iterable[str], uncalibrated: Collection[str] = ()) -> tuple[float, ...]:
        """Weights of the given blocks, in their order."""
        return tuple(self.get(block, 0.0 if block in uncalibrated else 1.0) for block in blocks)


class RequiredSigma(Numbers):
    """1-sigma, > 0, that a plan must reach in every axis of a state block.

    Keys end in the block's unit (`state_units`), in which the number is: ``attitude_deg``,
    ``gyro.bias_deg_h``, ``mag.bias_nt``; ``sun.bias``, parts of a unit vector, has none.

    Parameters
    ----------
    values : mapping of str to float, optional
        By keys; none asks for nothing.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> required = {"attitude_deg": 0.1, "mag.bias_nt": 30.0}
    >>> scenario = Scenario.from_dict({"preset": "paper", "required_sigma": required})
    >>> dict(scenario.required_sigma)
    {'attitude_deg': 0.1, 'mag.bias_nt': 30.0}
    """

    number = Positive

    def of(self, units: Mapping[str, Unit]) -> tuple[float, ...]:
        """Requirements of blocks of these units, in the filter's; infinite where there is none."""
        return tuple(
            self.get(unit.key(block), math.inf) / unit.key_factor for block, unit in units.items()
        )


def check_blocks(key: str, values: Mapping[str, float], known: Collection[str]) -> None:
    """Refuse, with an InvalidValue, a number for a block that is not among the `known`."""
    for block, value in values.items():
        if block not in known:
            expected = f"unknown state block{known_names(block, known)}"
            raise InvalidValue(f"{key}.{block}", value, expected)


def check_objectives(names: Sequence[str], blocks: Collection[str], required: bool) -> None:
    """Refuse, with an InvalidValue, names that do not say what to minimize.

    They may refer to the `blocks` of the state and, if any are `required`, to required 1-sigmas.
    """
    expect_unique("objectives[{}]", names)
    for i, name in enumerate(names):
        key = f"objectives[{i}]"
        unknown = [block for block in blocks_of(name) if block not in blocks]
        if unknown:
            known = known_names(unknown[0], blocks)
            raise InvalidValue(key, name, f"unknown state block {unknown[0]!r}{known}")
        if name not in OBJECTIVES and not blocks_of(name):
            known = known_names(name, [*OBJECTIVES, f"{TRACE_OF}BLOCK"])
            raise InvalidValue(key, name, f"unknown objective{known}")
        if name == "t_required" and not required:
            raise InvalidValue(key, name, "the scenario has no required_sigma")
