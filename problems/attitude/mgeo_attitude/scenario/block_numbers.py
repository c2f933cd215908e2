"""Numbers for blocks of the state: weights in the trace, and required 1-sigmas."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, BeforeValidator, GetCoreSchemaHandler
from pydantic_core import CoreSchema

from mgeo_attitude.settings.errors import InvalidValue, known_names
from mgeo_attitude.settings.tables import flatten
from mgeo_attitude.settings.types import NonNegative, Positive, Unit


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
