"""Sections as plain text and JSON records."""

import numpy as np
import pandas as pd
import pytest

from mgeo._text import wrap_text
from mgeo._text_table import format_section, lay_out_table
from mgeo.plugins.review import (
    Section,
    build_records,
    format_cells,
)

ROWS = pd.DataFrame(
    {"time [s]": [1.0, 1234.5678], "sun misalignment [deg]": [0.123456, np.nan], "who": ["a", "b"]},
    index=pd.Index(["start", "end of the run"], name="phase"),
)


def join_parts(table, width=80):
    return "\n\n".join(f"{head}\n{rows}" for head, rows in lay_out_table(table, width))


def test_table_has_units_below_names_and_aligned_numbers():
    head, *body = join_parts(ROWS).splitlines()[-4:]
    lines = [head, *body]
    assert lines[0].split() == ["time", "sun", "misalignment"]
    assert lines[1].split() == ["phase", "s", "deg", "who"]
    assert lines[2].split() == ["start", "1.00", "0.123", "a"]
    assert lines[3].split() == ["end", "of", "the", "run", "1235", "b"]
    ends = {
        line.index(text) + len(text) for line, text in zip(lines[2:], ("1.00", "1235"), strict=True)
    }
    assert len(ends) == 1


@pytest.mark.parametrize("width", [40, 60, 77])
def test_wide_tables_continue_below(width):
    table = pd.DataFrame(np.arange(24.0).reshape(2, 12), ["first", "second"]).add_prefix("value ")
    text = join_parts(table, width)
    assert max(map(len, text.splitlines())) <= width
    assert text.count("first") == len(text.split("\n\n")) > 1
    numbers = [float(word) for word in text.replace("value", "").split() if word.isdigit()]
    assert sorted(numbers)[-12:] == list(np.arange(12.0, 24.0))


def test_long_texts_are_wrapped():
    words = " ".join(["uncertainty"] * 12)
    section = Section("x", (words,), pd.DataFrame({"share": [1.0], "text": [words]}), words)
    text = "\n".join(text for _, text in format_section(section))
    assert max(map(len, text.splitlines())) <= 80
    assert text.count("uncertainty") == 36


def test_records_have_units_in_keys():
    first, _ = build_records(ROWS)
    assert first == {"phase": "start", "time_s": 1.0, "sun_misalignment_deg": 0.123456, "who": "a"}


def test_numbers_keep_their_integer_digits():
    values = [999.9, 1234.5, 0.000123456, 2e9, np.nan, 0.99999]
    texts = [row[0] for row in format_cells(pd.DataFrame({"a": values}))[1:]]
    assert texts == ["1000", "1234", "1.23e-04", "2.00e+09", "", "1.00"]
    assert [row[0] for row in format_cells(pd.DataFrame({"a": [10.0, 500.0]}))] == [
        "a",
        "10",
        "500",
    ]


def test_numbers_stay_with_their_units():
    text = wrap_text(
        "The filter converges in 90 % of Monte Carlo runs within 26 min 31 s.", width=20
    )
    assert text.split("\n")[1:3] == ["in 90 % of Monte", "Carlo runs within"]
    assert max(map(len, text.split("\n"))) <= 20
    assert text.endswith("31 s.")
