"""Tables on the terminal."""

import pandas as pd
import pytest

from mgeo._text import format_column, format_key, format_number, wrap_text
from mgeo.plugins.review import Section
from mgeo.terminal import Output


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


def test_key_of_a_ratio_differs_from_the_key_of_the_lower_bound():
    assert format_key("trace / lower bound [-]") == "trace_ratio_to_lower_bound"
    assert format_key("trace lower bound [-]") == "trace_lower_bound"


def test_wrapped_text_keeps_numbers_and_percent_signs_together():
    lines = wrap_text("x" * 77 + " 90 % of all", "  ").splitlines()
    assert max(map(len, lines)) <= 80
    assert lines[1].startswith("  90 %")


@pytest.fixture
def print_section(capsys):
    def print_lines(section):
        Output().print_sections(section)
        return capsys.readouterr().out.splitlines()

    return print_lines


def test_section_has_rows_up_to_its_maximum(print_section):
    table = pd.DataFrame({"time [s]": [1.0, 2.0, 3.0]}, index=["a", "b", "c"])
    table = table.rename_axis("event")
    section = Section("Events", ("Text.",), table, "Note.", {"time [s]": 1}, 2, "mgeo report")
    lines = print_section(section)
    assert [line.split() for line in lines[:6]] == [
        ["Events"],
        ["Text."],
        ["time"],
        ["event", "s"],
        ["a", "1.0"],
        ["b", "2.0"],
    ]
    assert lines[6].startswith("And 1 more")
    assert "mgeo report" in lines[6]
    assert lines[7:] == ["Note."]


def test_columns_of_wide_tables_continue_below(print_section):
    columns = {f"a long title of column {i} [deg/s]": [0.123456] for i in range(12)}
    table = pd.DataFrame(columns, index=["a name of twenty-five chars"])
    lines = print_section(Section("Name", table=table))
    assert max(map(len, lines)) <= 80
    assert sum(line.split().count("0.123") for line in lines) == 12
    assert sum(line.startswith("a name") for line in lines) > 1


def test_sections_are_separated_by_empty_lines(capsys):
    Output().print_sections(Section("First", ("- an item",)), Section("Second"))
    assert capsys.readouterr().out.splitlines() == ["First", "- an item", "", "Second"]


def test_long_texts_of_pairs_and_warnings_are_wrapped(capsys):
    words = " ".join(["uncertainty"] * 12)
    output = Output()
    output.print_pairs({"name": words})
    output.print_warnings([words])
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    assert sum(line.count("uncertainty") for line in lines) == 24
    assert lines[1].startswith("      uncertainty")


def test_commands_and_paths_are_not_wrapped(capsys):
    path = f"{'folder/' * 20}file.csv"
    output = Output()
    output.print_files({path: "rows"})
    output.print_commands({"Print": f"mgeo attitude show {path}"})
    text = capsys.readouterr().out
    assert f"{path}  rows\n" in text
    assert f"Print:  mgeo attitude show {path}\n" in text


def test_quiet_output_is_empty(capsys):
    output = Output(quiet=True)
    output.print_sections(Section("Title"))
    output.print_warnings(["x"])
    output.print_files({"a": "b"})
    output.print_commands({"a": "b"})
    assert capsys.readouterr().out == ""
