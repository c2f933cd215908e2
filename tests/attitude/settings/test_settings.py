"""Validation of settings, messages of errors, and conversion to tables."""

from __future__ import annotations

import math
from datetime import UTC, date, datetime
from typing import Annotated, Any, Literal

import pytest
from mgeo_attitude.settings.base import Settings, TableClasses, to_table
from mgeo_attitude.settings.errors import InvalidKey, InvalidValue
from mgeo_attitude.settings.types import Instant, PerAxis, Positive, Seconds, Triple, Unit
from pydantic import Field
from pydantic.dataclasses import dataclass


@dataclass(frozen=True)
class Bearing(Settings):
    selector = "kind"
    kind = "bearing"

    name: str = Field(default="front", description="name")
    friction: float = Field(default=0.1, ge=0.0, lt=1.0, description="coefficient of friction")


@dataclass(frozen=True)
class Wheel(Settings):
    inertia: Annotated[float, Unit("kg m²")] = Field(default=1.0, gt=0.0)
    """moment
    of inertia"""
    offset: float = Field(default=0.0, description="offset from the center")
    poles: int = Field(default=4, ge=2, description="magnetic poles")
    vented: bool = Field(default=False, description="open to vacuum")
    motor: Literal["dc", "ac"] = Field(default="dc", description="motor")
    run_time: Seconds | None = Field(default=None, gt=0.0, description="time until it stops")
    axis: Annotated[Triple[Positive], Unit("m")] = Field(
        default=(1.0, 1.0, 1.0), description="axis"
    )
    noise: PerAxis[Positive] = Field(default=1.0, description="noise")
    tags: tuple[str, ...] = Field(default=(), description="labels")
    built: Instant | None = Field(default=None, description="date of assembly")
    bearing: Bearing = Field(default_factory=Bearing, description="bearing")
    more_bearings: tuple[Annotated[Bearing, TableClasses("kind", {"bearing": Bearing})], ...] = (
        Field(default=(), description="further bearings")
    )


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"inertia": True}, "inertia = True: expected a number > 0 [kg m²] (moment of inertia)"),
        ({"inertia": "1"}, "inertia = '1': expected a number > 0 [kg m²] (moment of inertia)"),
        ({"offset": math.nan}, "offset = nan: expected a number (offset from the center)"),
        ({"poles": 4.0}, "poles = 4.0: expected an integer >= 2 (magnetic poles)"),
        ({"vented": 1}, "vented = 1: expected true or false (open to vacuum)"),
        ({"motor": "steam"}, "motor = 'steam': expected one of 'dc', 'ac' (motor)"),
        ({"run_time": 0}, "run_time = 0: expected nothing or a number > 0 [s] (time until"),
        ({"axis": (1, 2, 0)}, "axis[2] = 0: expected greater than 0 [m] (axis)"),
        ({"noise": (1, 0, 1)}, "noise = (1, 0, 1): expected a number > 0 or a list of 3 values"),
        ({"tags": ["a", 1]}, "tags[1] = 1: expected a valid string (labels)"),
        ({"built": date(2018, 6, 5)}, "built = '2018-06-05': expected nothing or a date and time"),
        ({"built": datetime(2018, 6, 5)}, "built = '2018-06-05T00:00:00': expected a UTC offset"),
        ({"bearing": 3}, "bearing = 3: expected a table (bearing)"),
        (
            {"bearing": {"friction": 1}},
            "bearing.friction = 1: expected a number >= 0 and < 1 (",
        ),
        (
            {"more_bearings": [{"kind": "bearing", "name": 1}]},
            "more_bearings[0].name = 1: expected a string",
        ),
        ({"inertai": 1.0}, "inertai: unknown key; did you mean 'inertia'? (known: 'inertia', 'of"),
        ({"bearing": {"kin": 1}}, "bearing.kin: unknown key; did you mean 'kind'? (known: 'kind'"),
    ],
)
def test_error_names_key_value_and_expected_values(values: Any, message: str) -> None:
    with pytest.raises(InvalidValue) as error:
        Wheel(**values)
    assert str(error.value).startswith(message)


def test_error_names_positional_and_missing_arguments() -> None:
    with pytest.raises(InvalidValue, match=r"^friction = 2: expected a number >= 0 and < 1"):
        Bearing("rear", 2)

    @dataclass(frozen=True)
    class Axle(Settings):
        length: Annotated[float, Unit("m")] = Field(description="length")

    with pytest.raises(InvalidKey, match=r"^length: missing; expected a number \[m\] \(len"):
        Axle()  # type: ignore[call-arg]


def test_table_contains_kind_and_no_empty_entries() -> None:
    table = to_table(
        Wheel(more_bearings=(Bearing("rear"),), built=datetime(2018, 6, 5, tzinfo=UTC))
    )
    assert not {"run_time", "tags"} & table.keys()
    assert table["built"] == "2018-06-05T00:00:00Z"
    assert table["more_bearings"] == [{"kind": "bearing", "name": "rear", "friction": 0.1}]
