"""Tables on terminals."""

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


def printed(width, titles=TITLES, rows=ROWS):
    console = Console(file=io.StringIO(), width=width)
    console.print(build_table(titles, rows))
    return console.file.getvalue().splitlines()


def test_a_table_that_fits_has_a_line_for_each_row():
    shown = build_table(TITLES, ROWS)
    width = next(width for width in range(400) if is_within_width(shown, width))
    (head, *lines) = printed(width)
    assert len(lines) == len(ROWS)
    assert all(title in head for title in TITLES)
    assert len(printed(width - 1)) > 1 + len(ROWS)
    assert max(map(len, printed(80))) <= 80
