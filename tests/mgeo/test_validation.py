"""What is refused is named, with its place, its value, and what was expected."""

import re

import pytest

from mgeo.validation.arguments import format_suggestion
from mgeo.validation.entries import get_entry
from mgeo.validation.tables import Table, validate_table


@pytest.mark.parametrize(
    ("value", "known", "told"),
    [
        ("nsag2", ["nsga2", "nsga3"], "; did you mean 'nsga2'?"),
        ("directed", ["mgeo-directed", "mgeo-real"], "; did you mean 'mgeo-directed'?"),
        ("bias", ["bias_decay", "initial_bias_nt", "basis"], None),
        ("bias_nt", ["bias_decay", "initial_bias_nt"], "; did you mean 'initial_bias_nt'?"),
        ("orbit", ["gyro", "sensors"], ""),
        (3, ["gyro", "3"], "; did you mean '3'?"),
    ],
)
def test_a_name_that_is_like_known_ones_or_a_part_of_them(value, known, told):
    told = "; did you mean 'bias_decay' or 'initial_bias_nt'?" if told is None else told
    assert format_suggestion(value, known) == told


@pytest.mark.parametrize(
    ("kind", "value", "message"),
    [
        (int, True, "x.a = True: expected an integer"),
        (float, True, "x.a = True: expected a finite number"),
        (float, float("nan"), "x.a = nan: expected a finite number"),
        (float, 10**400, "x.a = 1000"),
        (bool, 1, "x.a = 1: expected true or false"),
        (str, None, "x.a = None: expected a string"),
        (dict, [], "x.a = []: expected a table"),
        (list[str], ["a", 1], "x.a[1] = 1: expected a string"),
        (dict[str, int], {"b": "c"}, "x.a.b = 'c': expected an integer"),
    ],
)
def test_an_entry_of_another_kind_is_named(kind, value, message):
    with pytest.raises(TypeError, match=rf"^{re.escape(message)}"):
        get_entry({"a": value}, "a", kind, "x.")


def test_a_missing_entry_is_named_and_what_is_no_table():
    with pytest.raises(ValueError, match=r"^x\.a is missing$"):
        get_entry({}, "a", int, "x.")
    with pytest.raises(TypeError, match=r"^x = \[\]: expected a table$"):
        get_entry([], "a", int, "x.")


class Inner(Table):
    size: float


class Outer(Table):
    parts: list[Inner]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"parts": [{"size": "1"}]}, "parts[0].size = '1': expected a valid number"),
        ({"parts": [{"siz": 1}]}, "parts[0].siz is unknown: expected size; did you mean 'size'?"),
        ({"parts": [{}]}, "parts[0].size is missing"),
        ({}, "parts is missing"),
        ({"parts": 3}, "parts = 3: expected a valid list"),
    ],
)
def test_the_first_mistake_in_a_table_is_named(data, message):
    with pytest.raises(ValueError, match=rf"^{re.escape(message)}$"):
        validate_table(Outer, data)
