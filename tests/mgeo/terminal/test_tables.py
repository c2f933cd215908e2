"""Tables on the terminal."""

import io

import numpy as np
import pandas as pd
import pytest
from rich.console import Console

from mgeo._text import format_column, format_key, format_number, wrap_text
from mgeo.plugins.review import Section
from mgeo.terminal import build_table, is_within_width, render_section

TITLES = ("", "best t_end [s]", "knee", "between", "x, y, z in turn, there and back", "best trace")
ROWS = [
    ("start UTC", *(f"2018-06-05T00:{minute}:00.000000" for minute in range(10, 15))),
    ("misalignment of the sensor, 1-sigma [arcmin]", *np.geomspace(1.23456e-7, 9.87654e6, 5)),
    ("plans", *range(100_000, 100_005)),
]


def print_table(width, titles=TITLES, rows=ROWS):
    console = Console(file=io.StringIO(), width=width)
    console.print(build_table(titles, rows))
    return console.file.getvalue().splitlines()


def test_table_within_width_has_one_line_per_row():
    table = build_table(TITLES, ROWS)
    width = next(width for width in range(400) if is_within_width(table, width))
    head, *lines = print_table(width)
    assert len(lines) == len(ROWS)
    assert all(title in head for title in TITLES)
    assert len(print_table(width - 1)) > 1 + len(ROWS)
    assert max(map(len, print_table(80))) <= 80


@pytest.mark.parametrize(
    ("value", "decimals", "text"),
    [
        (1234.5, None, "1234"),
        (0.03364, None, "0.0336"),
        (1.1, None, "1.10"),
        (2.048e-6, None, "2.05e-06"),
        (-12.345, None, "-12.3"),
        (0.9996, 2, "1.00"),
        (-0.001, 2, "-0.00"),
        (0.0, None, "0"),
        (float("nan"), None, ""),
        (float("inf"), None, "inf"),
    ],
)
def test_numbers_have_three_digits_or_the_given_decimals(value, decimals, text):
    assert format_number(value, decimals) == text


def test_column_of_integers_has_no_decimals():
    assert format_column([1.0, 585.0, 6720.0]) == ["1", "585", "6720"]
    assert format_column([1.0, 585.5]) == ["1.00", "586"]
    assert format_column(["at most 2", 3]) == ["at most 2", "3"]


def test_keys_contain_the_units():
    titles = ["attitude 1-sigma [deg]", "rate x [deg/s]", "trace [-]", "90 % of runs"]
    keys = ["attitude_1sigma_deg", "rate_x_deg_s", "trace", "in_90_percent_of_runs"]
    assert list(map(format_key, titles)) == keys


def test_wrapped_text_keeps_numbers_and_percent_signs_together():
    lines = wrap_text("x" * 77 + " 90 % of all", "  ").splitlines()
    assert max(map(len, lines)) <= 80
    assert lines[1].startswith("  90 %")


def print_section(section):
    console = Console(file=io.StringIO(), width=80)
    console.print(*render_section(section), sep="\n")
    return [line.rstrip() for line in console.file.getvalue().splitlines()]


def test_section_has_rows_up_to_its_maximum():
    table = pd.DataFrame({"time [s]": [1.0, 2.0, 3.0]}, index=["a", "b", "c"])
    lines = print_section(Section("Event", ("Text.",), table, "Note.", {"time [s]": 1}, 2))
    assert [line.split() for line in lines[:5]] == [
        ["Text."],
        ["time"],
        ["Event", "s"],
        ["a", "1.0"],
        ["b", "2.0"],
    ]
    assert lines[5].startswith("And 1 more")
    assert lines[5].endswith("Note.")


def test_heads_are_wrapped_if_the_table_is_too_wide():
    columns = {f"a long title of column {i} [deg/s]": [0.123456] for i in range(6)}
    table = pd.DataFrame(columns, index=["a name of twenty-five chars"])
    lines = print_section(Section("Name", table=table))
    assert max(map(len, lines)) <= 80
    assert lines[-1].split()[-6:] == ["0.123"] * 6
