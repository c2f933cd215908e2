"""The small sections of a scenario: maneuvers, path limits, convergence, names of objectives.

`criteria.objectives` computes what the names say, `criteria.constraints` measures path limits.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BeforeValidator, Field, GetCoreSchemaHandler
from pydantic.dataclasses import dataclass
from pydantic_core import CoreSchema

from mgeo_attitude.criteria.objectives import OBJECTIVES, TRACE_OF, blocks_of
from mgeo_attitude.environment.directions import DIRECTIONS, Cone
from mgeo_attitude.geometry.vector import unit
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, expect, known_names
from mgeo_attitude.settings.tables import flatten
from mgeo_attitude.settings.types import (
    Degrees,
    DegreesPerSecond,
    Direction,
    NonNegative,
    Positive,
    Seconds,
    Unit,
    one_of,
)


@dataclass(frozen=True, kw_only=True)
class ManeuverLimits(Settings):
    """Bounds of the design vector.

    Examples
    --------
    >>> from mgeo_attitude.scenario import ManeuverLimits
    >>> ManeuverLimits(count=6, max_rate_deg_s=0.5, max_duration=900.0, slew_back=True).count
    6
    """

    count: int = Field(default=3, ge=1, le=100)
    """number of constant-rate maneuvers"""
    max_rate_deg_s: DegreesPerSecond = Field(default=1.0, gt=0.0)
    """greatest body rate per axis"""
    max_duration: Seconds = Field(default=2000.0, gt=0.0)
    """greatest duration of one maneuver"""
    max_acceleration_deg_s2: Annotated[float | None, Unit("deg/s²")] = Field(default=None, gt=0.0)
    """greatest angular acceleration per axis; without it rates change at once"""
    slew_back: bool = False
    """whether a plan ends, after t_end, with a slew back to the attitude of [initial]"""
    end_tolerance_deg: Degrees | None = Field(default=None, gt=0.0)
    """by how much the attitude may be off that of [initial] after the slew back, as 3 times the
    1-sigma about the worst axis that the filter knows then"""

    def __post_init__(self) -> None:
        needed = "none without slew_back = true: a plan then ends wherever its last maneuver does"
        alone = self.end_tolerance_deg is not None and not self.slew_back
        expect(not alone, "end_tolerance_deg", self.end_tolerance_deg, needed)


@dataclass(frozen=True, kw_only=True)
class PathLimit(Settings):
    """A cone around a body axis that a direction must stay out of, or in, along the whole plan.

    Of the Earth, a disc, the angle counts from the limb: inside of it it is negative. The Sun
    counts while it shines. The axis is where the filter believes it: the cone is kept with a margin
    of `attitude_sigmas` times the 1-sigma of the angle; equation (14) of docs/theory.md.

    Examples
    --------
    >>> from mgeo_attitude.scenario import PathLimit
    >>> PathLimit(name="camera", boresight=(0.0, 0.0, 1.0), half_angle_deg=20.0).sense
    'keep-out'
    """

    name: str = "payload"
    """name of the limit, for people"""
    reference: Annotated[str, one_of(DIRECTIONS)] = "sun"
    """direction that counts; of earth from the limb, of nadir from the Earth's center"""
    sense: Literal["keep-out", "keep-in"] = "keep-out"
    """whether it must stay out of the cone or in it"""
    boresight: Direction
    """axis of the cone, body axes (any length)"""
    half_angle_deg: Degrees = Field(gt=0.0, lt=180.0)
    """half-angle of the cone"""
    attitude_sigmas: float = Field(default=3.0, ge=0.0)
    """margin for the unknown attitude, in 1-sigmas of the angle; 0 is none"""

    def __post_init__(self) -> None:
        check_name(self.name)

    @property
    def keep_in(self) -> bool:
        return self.sense == "keep-in"

    @property
    def label(self) -> str:
        """What is limited, for people: ``Sun off camera``, ``nadir in antenna``."""
        way = "in" if self.keep_in else "off"
        return f"{DIRECTIONS[self.reference].label} {way} {self.name}"

    def cone(self) -> Cone:
        """The cone, in rad."""
        half_angle = math.radians(self.half_angle_deg)
        return Cone(self.reference, unit(self.boresight), half_angle, self.keep_in)


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


class Numbers(Mapping[str, float]):
    """Numbers by names with dots, such as ``mag.bias``; immutable and hashable.

    A table may nest them: ``{"mag": {"bias": 1.0}}``.
    """

    #: Range of the numbers.
    number: ClassVar[Any] = float

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


def check_name(name: str) -> None:
    """Refuse, with an InvalidValue, a ``name`` that would not fit a line of text."""
    sound = name.isprintable() and name.strip()
    expect(sound, "name", name, "printable characters on one line")


def check_objectives(names: Sequence[str], blocks: Collection[str], required: bool) -> None:
    """Refuse, with an InvalidValue, names that do not say what to minimize.

    They may refer to the `blocks` of the state and, if any are `required`, to required 1-sigmas.
    """
    if not names:
        raise InvalidValue("objectives", [], "expected at least one name")
    for i, name in enumerate(names):
        key = f"objectives[{i}]"
        if name in names[:i]:
            raise InvalidValue(key, name, "expected each one once")
        unknown = [block for block in blocks_of(name) if block not in blocks]
        if unknown:
            known = known_names(unknown[0], blocks)
            raise InvalidValue(key, name, f"unknown state block {unknown[0]!r}{known}")
        if name not in OBJECTIVES and not blocks_of(name):
            known = known_names(name, [*OBJECTIVES, f"{TRACE_OF}BLOCK"])
            raise InvalidValue(key, name, f"unknown objective{known}")
        if name == "t_required" and not required:
            raise InvalidValue(key, name, "the scenario has no required_sigma")
