"""The oracle table of docs/algorithms.md: published values beside those of the variants here.

    python -m tests.benchmarks.oracle_table FILE [FIRST:LAST]

appends a line an oracle to FILE, those of a slice of `ORACLES` or all; about 20 s each.
"""

import sys
from pathlib import Path

import numpy as np

from tests.mgeo.algorithms.oracles import ORACLES

N_RUNS = 50


def number(value):
    """Three digits."""
    return "0" if value == 0 else f"{value:.3g}"


def line(oracle):
    """A row of the table: function, variant, published and found mean and median."""
    best = oracle.bests(N_RUNS)
    cells = (oracle.mean, best.mean(), oracle.median, np.median(best))
    return f"| {oracle.function} | `{oracle.label}` | {' | '.join(map(number, cells))} |"


def main(path, rows=":"):
    first, last = (int(part) if part else None for part in rows.split(":"))
    for oracle in ORACLES[first:last]:
        with Path(path).open("a") as table:
            print(line(oracle), file=table, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
