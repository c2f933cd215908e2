"""Tables on the terminal."""

import io

import numpy as np
from rich.console import Console

from mgeo.terminal import build_table, is_within_width

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
