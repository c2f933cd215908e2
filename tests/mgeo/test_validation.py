"""Validation errors state the place, the value and the expectation."""

import re

import pytest

from mgeo.validation.arguments import format_suggestion
from mgeo.validation.entries import get_entry
from mgeo.validation.tables import Table, validate_table


@pytest.mark.parametrize(
    ("value", "known", "expected"),
    [
        ("nsag2", ["nsga2", "nsga3"], "; did you mean 'nsga2'?"),
        ("directed", ["mgeo-directed", "mgeo-real"], "; did you mean 'mgeo-directed'?"),
        (
            "bias",
            ["bias_decay", "initial_bias_nt", "basis"],
            "; did you mean 'bias_decay' or 'initial_bias_nt'?",
        ),
        ("bias_nt", ["bias_decay", "initial_bias_nt"], "; did you mean 'initial_bias_nt'?"),
        (
            "bias_deg_h",
            ["bias_decay", "initial_bias_deg_s"],
            "; did you mean 'initial_bias_deg_s'?",
        ),
        ("orbit", ["gyro", "sensors"], ""),
        (3, ["gyro", "3"], "; did you mean '3'?"),
    ],
)
def test_suggestion_contains_similar_and_containing_names(value, known, expected):
    assert format_suggestion(value, known) == expected


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
def test_entry_of_wrong_type_is_rejected_with_its_place(kind, value, message):
    with pytest.raises(TypeError, match=rf"^{re.escape(message)}"):
        get_entry({"a": value}, "a", kind, "x.")


def test_missing_entry_and_content_other_than_table_are_rejected():
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
        ({"parts": [{"size": "1"}]}, "parts[0].size = '1': expected a number"),
        ({"parts": [{"siz": 1}]}, "parts[0].siz is unknown: expected size; did you mean 'size'?"),
        ({"parts": [{}]}, "parts[0].size is missing"),
        ({}, "parts is missing"),
        ({"parts": 3}, "parts = 3: expected a list"),
    ],
)
def test_first_mistake_in_table_is_reported_with_its_place(data, message):
    with pytest.raises(ValueError, match=rf"^{re.escape(message)}$"):
        validate_table(Outer, data)
