"""Every run behind docs/experiments/README.md; those already recorded are not made again.

    python -m tests.benchmarks.variant.everything [--seconds 600] [--part rivals]

Seeds come one after the other, so that stopping early leaves every algorithm with about as many
runs. All of it takes about four hours of one core; `tables` shows what there is so far.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass

from .record import record
from .spaces import INDICATOR, RAW
from .tables import FOLDER, OURS, RIVALS

SEEDS = 20
MORE_SEEDS = 40  # of ours and of its nearest rival, as 20 show no significant difference
NEAREST = ("nsga2", RAW)
PARTS = ("directed", "rivals", "ablation", "restarts", "elsewhere")

# What each part of the variant is worth: each changed alone.
CHANGES = (
    "", "extreme_weights=0.0", "difference=0.0", "coupling=(0.0,0.0)", "coupling=(0.1,0.5)",
    "coupling=(0.5,0.5)",
    "widths=(1.0,1.0)", "widths=(0.01,1.0)", "return_to_best=0.0", "return_to_best=0.7",
    "migrate=(0.0,0.0)", "migrate=(0.2,0.2)",
    "tau=1.5", "tau=6.0", "n_walkers=5", "n_walkers=15", "max_candidates=6",
)  # fmt: skip
ABLATION_SEEDS, ABLATION_EVALUATIONS = 6, 20_000

# What restarts and the coupling are worth, which takes long runs and many seeds to see.
RESTARTS = (
    "", "restart=(1000000,1000000)", "restart=(4,1000000)", "restart=(1000000,50)",
    "restart=(50,50)",
    "coupling=(0.1,0.5)", "coupling=(0.4,0.6)",
)  # fmt: skip
RESTART_SEEDS = 16

ELSEWHERE = (
    "zdt1", "zdt2", "zdt3", "zdt4", "zdt6", "dtlz1", "dtlz2", "dtlz7", "wfg1", "wfg4", "wfg9",
)  # fmt: skip
ELSEWHERE_RIVALS = ("nsga2", "sms-emoa", "gde3", "moead")
ELSEWHERE_SEEDS, ELSEWHERE_EVALUATIONS = 3, 10_000


@dataclass(frozen=True)
class Wanted:
    """Runs that differ only in their seed."""

    part: str
    problem: str
    algorithm: str
    space: str
    evaluations: int
    seeds: tuple[int, ...]


def variant(change: str) -> str:
    """Ours with a parameter changed, or as shipped."""
    return f"{OURS}:{change}" if change else OURS


def wanted() -> Iterator[Wanted]:
    """All runs, in the order in which they are made."""
    together = tuple(range(1, SEEDS + 1))
    for seed in together:
        yield Wanted("directed", "attitude", OURS, RAW, 60_000, (seed,))
        for rival in RIVALS:
            if rival != "moead":
                for space in (RAW, INDICATOR):
                    yield Wanted("rivals", "attitude", rival, space, 60_000, (seed,))
    for seed in range(SEEDS + 1, MORE_SEEDS + 1):
        yield Wanted("directed", "attitude", OURS, RAW, 60_000, (seed,))
        yield Wanted("rivals", "attitude", *NEAREST, 60_000, (seed,))
    for space in (RAW, INDICATOR):  # side by side, see `record.runs`
        yield Wanted("rivals", "attitude", "moead", space, 60_000, together)
    for seed in range(1, ABLATION_SEEDS + 1):
        for change in CHANGES:
            yield Wanted(
                "ablation", "attitude", variant(change), RAW, ABLATION_EVALUATIONS, (seed,)
            )
    for seed in range(1, RESTART_SEEDS + 1):
        for text in (*(variant(change) for change in RESTARTS), "nsga2"):
            yield Wanted("restarts", "attitude-coarse", text, RAW, 60_000, (seed,))
    for algorithm in (OURS, *ELSEWHERE_RIVALS):
        for problem in ELSEWHERE:
            seeds = tuple(range(1, ELSEWHERE_SEEDS + 1))
            yield Wanted("elsewhere", problem, algorithm, RAW, ELSEWHERE_EVALUATIONS, seeds)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=float("inf"), help="begin no run after")
    parser.add_argument("--part", choices=PARTS)
    given = parser.parse_args()
    begin = time.monotonic()
    for runs in wanted():
        left = given.seconds - (time.monotonic() - begin)
        if left <= 0:
            break
        if given.part in (None, runs.part):
            path = FOLDER / f"{runs.part}.csv"
            made = record(
                path, runs.problem, runs.algorithm, runs.space, list(runs.seeds),
                runs.evaluations, left,
            )  # fmt: skip
            if made:
                print(f"{runs.problem} {runs.algorithm} {runs.space}: {made} runs", flush=True)


if __name__ == "__main__":
    main()
