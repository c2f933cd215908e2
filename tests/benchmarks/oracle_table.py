"""Table of docs/explanation/algorithms.md: published results and those of this project.

``python -m tests.benchmarks.oracle_table FILE [FIRST:LAST]`` appends one row to FILE for each
oracle in a slice of `ORACLES`, by default for all. An oracle takes about 20 s.
"""

import sys
from pathlib import Path

import numpy as np

from tests.mgeo.algorithms.oracles import ORACLES

N_RUNS = 50


def format_number(value):
    """Format a number with three significant digits."""
    return "0" if value == 0 else f"{value:.3g}"


def format_row(oracle):
    """Return a table row with function, variant, and published and measured mean and median."""
    best = oracle.bests(N_RUNS)
    cells = (oracle.mean, best.mean(), oracle.median, np.median(best))
    return f"| {oracle.function} | `{oracle.label}` | {' | '.join(map(format_number, cells))} |"


def main(path, rows=":"):
    first, last = (int(part) if part else None for part in rows.split(":"))
    for oracle in ORACLES[first:last]:
        with Path(path).open("a") as table:
            print(format_row(oracle), file=table, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
