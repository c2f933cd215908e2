"""Criteria of plans: convergence, objectives, required 1-sigmas and Monte Carlo runs.

The package `criteria` computes objectives and constraints from these settings.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BeforeValidator, Field, GetCoreSchemaHandler
from pydantic.dataclasses import dataclass
from pydantic_core import CoreSchema

from mgeo_attitude.criteria.objectives import OBJECTIVES, TRACE_PREFIX, parse_trace_blocks
from mgeo_attitude.settings.base import Settings, flatten_keys
from mgeo_attitude.settings.errors import InvalidValue, expect, expect_unique, format_known_names
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
    """Rule that determines the end time t_end of a plan.

    A plan ends when the filter has converged, or at the end of the last maneuver.

    Examples
    --------
    >>> from mgeo_attitude.scenario import Convergence
    >>> Convergence(rule="end").rule
    'end'
    """

    rule: Literal["trace", "required", "settling", "end"] = "trace"
    """definition of t_end. 'trace': the first time after the maneuvers at which the trace has
    decreased by less than relative_decrease over the window; 'required': the first time after which
    no 1-sigma exceeds its value in required_sigma until the end of duration; 'settling': the first
    time after which the trace is at most factor times its value at the end of duration; 'end': the
    end of the last maneuver. The preset paper has the rule 'trace', the other presets have 'end'"""
    factor: float = Field(default=1.25, gt=1.0)
    """factor of the rule 'settling', relative to the trace at the end of duration"""
    window: Seconds = Field(default=300.0, gt=0.0)
    """window of the rule 'trace', a multiple of the step"""
    relative_decrease: float = Field(default=0.01, gt=0.0, lt=1.0)
    """relative decrease of the trace over the window below which the filter has converged, provided
    that the trace did not rise; 0.05 in the preset paper"""
    allow_rise: bool = False
    """true if the filter also counts as converged when the trace rises over the window"""


@dataclass(frozen=True, kw_only=True)
class MonteCarloSettings(Settings):
    """Settings of the Monte Carlo evaluation of plans.

    They specify the number of runs and the distributions of the random errors. Run k of a seed does
    not depend on the number of runs.

    Examples
    --------
    >>> from mgeo_attitude.scenario import MonteCarloSettings
    >>> MonteCarloSettings(n_runs=32, attitude_deg=5.0, rate_error_deg_s=0.01).quantile
    0.9
    """

    n_runs: int = Field(default=16, ge=1, le=10_000)
    """number of Monte Carlo runs; all plans are evaluated in the same runs"""
    seed: int = Field(default=0, ge=0)
    """seed of the random errors"""
    quantile: float = Field(default=0.9, gt=0.0, le=1.0)
    """share of the runs in which the value of an objective must hold; 1 for the worst run"""
    mean: bool = False
    """true if objectives are means over the runs instead of quantiles"""
    constraint_share: float = Field(default=1.0, gt=0.0, le=1.0)
    """share of the runs in which each constraint must be satisfied"""
    fidelities: tuple[Annotated[int, Field(ge=0, le=10_000)], ...] = ()
    """numbers of runs at the lower fidelity levels of a search, in ascending order; 0 for the
    nominal run alone"""
    attitude_deg: Degrees | None = Field(default=None, ge=0.0, le=180.0)
    """initial attitude error, 1-sigma per axis; default: initial.attitude_deg"""
    rate_error_deg_s: DegreesPerSecond | None = Field(default=None, ge=0.0)
    """error common to all body rates of a run, 1-sigma per axis; default: the gyro's initial
    bias"""
    maneuver_rate_error_deg_s: DegreesPerSecond = Field(default=0.0, ge=0.0)
    """independent error of the body rate of each maneuver, 1-sigma per axis"""
    duration_error: Seconds = Field(default=0.0, ge=0.0)
    """error of the duration of each maneuver, 1-sigma"""
    start_delay: Seconds = Field(default=0.0, ge=0.0, le=31 * 86400.0)
    """largest delay of the start, uniformly distributed from 0; 604800 for plans that start at any
    time of a week"""

    noise_spread: float = Field(default=0.0, ge=0.0, le=2.0)
    """uncertainty of the noise level of the gyro and of each sensor: 1-sigma of the logarithm of
    the ratio of actual to modeled noise"""

    def __post_init__(self) -> None:
        counts = [*self.fidelities, self.n_runs]
        expected = f"ascending numbers up to n_runs = {self.n_runs}"
        expect(counts == sorted(counts), "fidelities", self.fidelities, expected)

    def n_runs_at_fidelity(self, fidelity: int | None) -> int:
        """Return the number of Monte Carlo runs at a fidelity level of the search.

        Levels are counted from 0. Levels after the last, and None, use all runs.
        """
        counts = [*self.fidelities, self.n_runs]
        return self.n_runs if fidelity is None else counts[min(fidelity, len(counts) - 1)]


class BlockValues(dict[str, float]):
    """Hashable dict that maps block names, such as ``mag.bias``, to numbers.

    In a file, the names may be nested tables: ``{"mag": {"bias": 1.0}}``.
    """

    #: Type of the numbers, including their valid range.
    number_type: ClassVar[Any] = float

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(frozenset(self.items()))

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        nested = dict[str, cls.number_type | dict[str, cls.number_type]]  # type: ignore[name-defined]
        flat = Annotated[
            dict[str, cls.number_type],  # type: ignore[name-defined]
            BeforeValidator(flatten_keys, json_schema_input_type=nested),
            AfterValidator(cls),
        ]
        return handler.generate_schema(flat)


class TraceWeights(BlockValues):
    """Weight of each block in the trace of the covariance, keyed by block name.

    Weights are at least 0. A block without an entry has the weight 1, or 0 if no plan can reduce
    its error (`Suite.uncalibrated_blocks`).

    Parameters
    ----------
    values : mapping of str to float, optional
        Weights, keyed by block name.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> scenario = Scenario.from_dict({"preset": "paper", "trace_weights": {"attitude": 10.0}})
    >>> dict(scenario.trace_weights)
    {'attitude': 10.0}
    """

    number_type = NonNegative

    def list_weights(
        self, blocks: Iterable[str], uncalibrated: Collection[str] = ()
    ) -> tuple[float, ...]:
        """Return the weights of blocks in the trace of the covariance, in the order of `blocks`.

        Parameters
        ----------
        blocks : iterable of str
            Names of blocks of the error state.
        uncalibrated : collection of str
            Blocks whose default weight is 0 instead of 1.
        """
        return tuple(self.get(block, 0.0 if block in uncalibrated else 1.0) for block in blocks)


class RequiredSigma(BlockValues):
    """Required 1-sigma of each block, keyed by block name and unit.

    Values are above 0. Each axis of the block must satisfy the requirement. Keys end in the unit of
    the number: ``attitude_deg``, ``gyro.bias_deg_h``, ``mag.bias_nt``; ``sun.bias``, part of a unit
    vector, has no unit.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> required = {"attitude_deg": 0.1, "mag.bias_nt": 30.0}
    >>> scenario = Scenario.from_dict({"preset": "paper", "required_sigma": required})
    >>> dict(scenario.required_sigma)
    {'attitude_deg': 0.1, 'mag.bias_nt': 30.0}
    """

    number_type = Positive

    def list_sigmas(self, units: Mapping[str, Unit]) -> tuple[float, ...]:
        """Return the required 1-sigma of each block in the filter's units.

        The value is infinite for a block without a requirement.

        Parameters
        ----------
        units : mapping
            Unit of each block; the result is in this order.
        """
        return tuple(
            self.get(unit.build_key(block), math.inf) / unit.key_factor
            for block, unit in units.items()
        )


def check_blocks(key: str, values: Mapping[str, float], known: Collection[str]) -> None:
    """Raise InvalidValue if a table has a key that is not the name of a block.

    Parameters
    ----------
    key : str
        Key of the table in the message.
    values : mapping of str to float
        Numbers, keyed by block name.
    known : collection of str
        Valid names.
    """
    for block, value in values.items():
        if block not in known:
            expected = f"unknown state block{format_known_names(block, known)}"
            raise InvalidValue(f"{key}.{block}", value, expected)


def check_objectives(names: Sequence[str], blocks: Collection[str], required: bool) -> None:
    """Raise InvalidValue if an objective is repeated, unknown or not defined by the scenario.

    Parameters
    ----------
    names : sequence of str
        Names of objectives.
    blocks : collection of str
        Blocks of the error state to which names may refer.
    required : bool
        Whether the scenario has required 1-sigmas.
    """
    expect_unique("objectives[{}]", names)
    for i, name in enumerate(names):
        key = f"objectives[{i}]"
        unknown = [block for block in parse_trace_blocks(name) if block not in blocks]
        if unknown:
            known = format_known_names(unknown[0], blocks)
            raise InvalidValue(key, name, f"unknown state block {unknown[0]!r}{known}")
        if name not in OBJECTIVES and not parse_trace_blocks(name):
            known = format_known_names(name, [*OBJECTIVES, f"{TRACE_PREFIX}BLOCK"])
            raise InvalidValue(key, name, f"unknown objective{known}")
        if name == "t_required" and not required:
            expected = "the scenario has no required_sigma: define it, or remove the objective"
            raise InvalidValue(key, name, expected)
