"""Tables on terminals of every width: all of each number, and no line too long."""

import io

import numpy as np
import pytest
from rich.console import Console

from mgeo.terminal import table

TITLES = ("", "best t_end [s]", "knee", "between", "x, y, z in turn, there and back", "best trace")
ROWS = [
    ("start UTC", *(f"2018-06-05T00:{minute}:00.000000" for minute in range(10, 15))),
    ("misalignment of the sensor, 1-sigma [arcmin]", *np.geomspace(1.23456e-7, 9.87654e6, 5)),
    ("maneuver 1: x / y / z [deg/s] for d [s]", *["+1.000 / -0.125 / +0.062 for 2000.0"] * 5),
    ("plans", *range(100_000, 100_005)),
]


def printed(width, titles=TITLES, rows=ROWS):
    console = Console(file=io.StringIO(), width=width)
    console.print(table(titles, rows))
    return console.file.getvalue().splitlines()


@pytest.mark.parametrize("width", range(52, 240, 9))
def test_no_word_is_broken_and_no_line_too_long(width):
    lines = printed(width)
    assert max(map(len, lines)) <= width
    words = " ".join(lines).split()
    for row in ROWS:
        for cell in row[1:]:
            text = f"{cell:.5g}" if isinstance(cell, float) else str(cell)
            assert set(text.split()) <= set(words)
    assert not any("…" in line for line in lines)


def test_what_fits_is_one_table():
    (head, *lines) = printed(240)
    assert len(lines) == len(ROWS)
    assert all(title in head for title in TITLES)


def test_blocks_carry_the_first_column():
    """Each block has a line for each row that begins with its label."""
    lines = printed(80)
    starts = [line for line in lines if line.startswith("start UTC")]
    assert len(starts) == lines.count("") + 1 > 1
    assert sum(line.split().count("plans") for line in lines) == len(starts)
    found = [cell for line in lines if line.startswith("plans") for cell in line.split()[1:]]
    assert found == [str(cell) for cell in ROWS[-1][1:]]


def test_a_terminal_too_narrow_for_a_word_breaks_it():
    lines = printed(16, ("", "UTC"), [("t", "2018-06-05T00:10:00.000000")])
    assert max(map(len, lines)) <= 16
    letters = "".join(" ".join(lines[1:]).split())
    assert letters.replace("t", "") == "2018-06-05T00:10:00.000000"


def test_texts_are_left_and_numbers_right():
    (_, first, second) = printed(40, ("a", "b"), [("x", 1.0), ("long", 10.25)])
    assert (first.rstrip(), second.rstrip()) == ("x          1", "long   10.25")
