"""Self-checking dataclass fields: types, ranges and what the errors say."""

from __future__ import annotations

import copy
import math
import pickle
from dataclasses import FrozenInstanceError, dataclass, make_dataclass
from datetime import datetime
from typing import Any

import numpy as np
import pytest
from mgeo_attitude.fields.checking import Validated
from mgeo_attitude.fields.quantity import InvalidType, InvalidValue, Quantity, quantity


@dataclass(frozen=True, kw_only=True)
class Wheel(Validated):
    inertia: float = quantity(1.0, unit="kg m²", low=0.0, open_low=True, doc="moment of inertia")
    eccentricity: float = quantity(0.0, low=0.0, high=1.0, open_high=True, doc="off center")
    offset: float = quantity(0.0, unit="m", doc="place on the shaft")
    efficiency: float = quantity(0.5, high=1.0, doc="share that arrives")
    poles: int = quantity(4, low=2, doc="magnetic poles")
    vented: bool = quantity(False, doc="open to vacuum")
    motor: str = quantity("dc", choices=("dc", "ac"), doc="motor")
    axis: tuple[float, float, float] = quantity((0.0, 0.0, 1.0), low=-1.0, high=1.0, doc="axis")
    tags: tuple[str, ...] = quantity((), doc="labels")
    built: datetime | None = quantity(None, doc="date of assembly")


@dataclass(frozen=True)
class Bare(Validated):
    value: float = 0.0


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("inertia", 0.0, "inertia = 0.0: expected a number > 0 kg m² (moment of inertia)"),
        ("inertia", -2, "inertia = -2: expected a number > 0 kg m² (moment of inertia)"),
        ("eccentricity", 1.0, "eccentricity = 1.0: expected a number in [0, 1) (off center)"),
        ("eccentricity", -0.1, "eccentricity = -0.1: expected a number in [0, 1) (off center)"),
        ("efficiency", 1.5, "efficiency = 1.5: expected a number <= 1 (share that arrives)"),
        ("offset", math.nan, "offset = nan: expected a number in m (place on the shaft)"),
        ("offset", math.inf, "offset = inf: expected a number in m (place on the shaft)"),
        ("offset", -math.inf, "offset = -inf: expected a number in m (place on the shaft)"),
        ("poles", 1, "poles = 1: expected an integer >= 2 (magnetic poles)"),
        ("motor", "steam", "motor = 'steam': expected one of 'dc', 'ac' (motor)"),
        ("axis", (1, 0), "axis = (1, 0): expected a list of 3 x (a number in [-1, 1]) (axis)"),
        ("axis", (0, 0, 2), "axis[2] = 2: expected a number in [-1, 1] (axis)"),
    ],
)
def test_a_bad_value_is_named_with_its_range(field: str, value: Any, message: str) -> None:
    with pytest.raises(InvalidValue) as caught:
        Wheel(**{field: value})
    assert str(caught.value) == message
    assert not isinstance(caught.value, TypeError)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("inertia", True, "inertia = True: expected a number > 0 kg m² (moment of inertia)"),
        ("inertia", np.True_, "expected a number > 0 kg m²"),
        ("inertia", "1", "inertia = '1': expected a number > 0 kg m² (moment of inertia)"),
        ("inertia", 1j, "inertia = 1j: expected a number > 0 kg m² (moment of inertia)"),
        ("poles", True, "poles = True: expected an integer >= 2 (magnetic poles)"),
        ("poles", 4.0, "poles = 4.0: expected an integer >= 2 (magnetic poles)"),
        ("vented", 1, "vented = 1: expected true or false (open to vacuum)"),
        ("motor", 3, "motor = 3: expected one of 'dc', 'ac' (motor)"),
        ("axis", 3.0, "axis = 3.0: expected a list of 3 x (a number in [-1, 1]) (axis)"),
        ("axis", (0, True, 0), "axis[1] = True: expected a number in [-1, 1] (axis)"),
        ("tags", "ab", "tags = 'ab': expected a list of (a string) (labels)"),
        ("tags", ["a", 1], "tags[1] = 1: expected a string (labels)"),
        ("built", "now", "built = 'now': expected nothing or datetime (date of assembly)"),
    ],
)
def test_a_wrong_type_is_a_type_error(field: str, value: Any, message: str) -> None:
    with pytest.raises(TypeError) as caught:
        Wheel(**{field: value})
    assert isinstance(caught.value, InvalidType)
    assert message in str(caught.value)


def test_numbers_become_python_floats_and_ints() -> None:
    values: dict[str, Any] = {"offset": np.float32(0.5), "poles": np.int64(6), "axis": [1, 0, 0]}
    wheel = Wheel(inertia=2, **values)
    assert (wheel.inertia, wheel.offset, wheel.poles) == (2.0, 0.5, 6)
    assert [type(x) for x in (wheel.inertia, wheel.offset, wheel.poles)] == [float, float, int]
    assert wheel.axis == (1.0, 0.0, 0.0)
    assert all(type(x) is float for x in wheel.axis)


def test_an_integer_no_float_can_hold_is_refused() -> None:
    with pytest.raises(InvalidValue, match="offset = 1000"):
        Wheel(offset=10**400)


def test_the_ends_of_a_range_are_in_it_where_they_are_closed() -> None:
    def allows(value: float, **ends: bool) -> bool:
        ranged = quantity(1.5, low=1.0, high=2.0, **ends)
        cls = make_dataclass("Ranged", [("x", float, ranged)], bases=(Validated,), frozen=True)
        try:
            return cls(value).x == value
        except InvalidValue:
            return False

    assert [allows(x) for x in (1.0, 1.5, 2.0)] == [True, True, True]
    opened = [allows(x, open_low=True, open_high=True) for x in (1.0, 1.5, 2.0)]
    assert opened == [False, True, False]
    assert [allows(np.nextafter(x, y)) for x, y in ((1, 0), (2, 3))] == [False, False]


@pytest.mark.parametrize(
    ("spec", "text"),
    [
        (Quantity(), ""),
        (Quantity(unit="nT"), "in nT"),
        (Quantity(low=0.0), ">= 0"),
        (Quantity(high=2.5, open_high=True, unit="s"), "< 2.5 s"),
        (Quantity(low=-360.0, high=360.0, unit="deg"), "in [-360, 360] deg"),
        (Quantity(low=6378136.3, open_low=True, unit="m"), "> 6378136.3 m"),
    ],
)
def test_ranges_in_words(spec: Quantity, text: str) -> None:
    assert spec.range_text() == text


def test_a_field_without_declaration_is_checked_by_its_annotation() -> None:
    nothing: Any = None
    assert Bare(3).value == 3.0
    with pytest.raises(InvalidValue, match=r"^value = nan: expected a finite number$"):
        Bare(math.nan)
    with pytest.raises(InvalidType, match=r"^value = None: expected a finite number$"):
        Bare(nothing)


def test_instances_stay_frozen() -> None:
    wheel: Any = Wheel()
    with pytest.raises(FrozenInstanceError):
        wheel.inertia = 2.0


def test_a_misspelled_declaration_fails_at_once() -> None:
    with pytest.raises(TypeError, match="lowest"):
        quantity(1.0, doc="x", lowest=0.0)


@pytest.mark.parametrize("kind", [InvalidValue, InvalidType])
def test_errors_move_into_sections_and_between_processes(kind: type[InvalidValue]) -> None:
    error = kind("e", 1.2, "expected less").under("orbit")
    assert str(error) == "orbit.e = 1.2: expected less"
    for twin in (pickle.loads(pickle.dumps(error)), copy.copy(error)):
        assert type(twin) is kind
        assert str(twin) == str(error)
