"""Runs one after the other, a line of a table for each budget; finished ones are not repeated.

    python -m tests.benchmarks.variant.record TABLE --algorithm nsga2 --space indicator --seeds 1-20

Every line is the hypervolume of all nondominated points among the first N evaluations of a run.
An algorithm is a name of `mgeo.runs.algorithms`, with parameters after a colon:
`mgeo-real:sigma=0.5,perturbation='range'`. None of them knows its budget: a run serves all budgets.
"""

from __future__ import annotations

import argparse
import ast
import csv
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pymoo
from pymoo.core.algorithm import Algorithm
from pymoo.core.population import Population

from mgeo.runs.algorithms import build_algorithm
from mgeo.runs.solve import set_up

from .spaces import INDICATOR, RAW, Scale, Watched, problem_by_name

BUDGETS = (5_000, 20_000, 60_000)
COLUMNS = (
    "problem", "algorithm", "space", "seed", "evaluations", "hypervolume", "points", "seconds",
    "commit", "pymoo",
)  # fmt: skip


def build(text: str, problem: Watched) -> Algorithm:
    """The algorithm called `name` or `name:key=value,...`."""
    name, _, rest = text.partition(":")
    call = ast.parse(f"parameters({rest})", mode="eval").body
    given = {keyword.arg: ast.literal_eval(keyword.value) for keyword in call.keywords}
    return build_algorithm(name, given, problem)


def runs(text: str, problem: Watched, seeds: list[int], evaluations: int) -> Iterator[np.ndarray]:
    """The objectives of the first `evaluations` evaluations of each run, (evaluations, n_obj).

    MOEA/D asks for one evaluation at a time, which leaves seven of the filter's eight lanes
    empty: its runs go side by side and share batches. Results do not depend on that.
    """
    side_by_side = len(seeds) if text.startswith("moead") else 1
    for first in range(0, len(seeds), side_by_side):
        group = seeds[first : first + side_by_side]
        fresh = build(text, problem)
        algorithms = [set_up(problem, fresh, evaluations, seed) for seed in group]
        traces: list[list[np.ndarray]] = [[] for _ in group]
        done = 0
        while done < evaluations:
            asked = [algorithm.ask() for algorithm in algorithms]
            sizes = [len(np.atleast_1d(infills)) for infills in asked]
            problem.seen.clear()
            pop = (
                Population.merge(*(_population(infills) for infills in asked))
                if len(asked) > 1
                else _population(asked[0])
            )
            algorithms[0].evaluator.eval(problem, pop)
            parts = np.split(np.concatenate(problem.seen), np.cumsum(sizes)[:-1])
            for algorithm, infills, trace, part in zip(
                algorithms, asked, traces, parts, strict=True
            ):
                trace.append(part)
                algorithm.tell(infills=infills)
            done += min(sizes)
        for trace in traces:
            yield np.concatenate(trace)[:evaluations]


def _population(infills: Any) -> Population:
    return infills if isinstance(infills, Population) else Population.create(infills)


def read(path: Path) -> list[dict[str, str]]:
    """The lines of a table, none if there is no such file."""
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def append(path: Path, rows: list[dict[str, Any]]) -> None:
    """Add lines to a table, begun with its header."""
    new = not path.exists()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        if new:
            writer.writeheader()
        writer.writerows(rows)


def record(
    path: Path, name: str, text: str, space: str, seeds: list[int], evaluations: int, seconds: float
) -> int:
    """Make the runs that the table lacks, until `seconds` have passed. Returns how many."""
    problem = Watched(problem_by_name(name), space)
    scale = Scale(problem.problem)
    finished = {
        int(row["seed"])
        for row in read(path)
        if (row["problem"], row["algorithm"], row["space"]) == (name, text, space)
        and int(row["evaluations"]) >= evaluations
    }
    missing = [seed for seed in seeds if seed not in finished]
    budgets = [n for n in BUDGETS if n < evaluations] + [evaluations]
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True
    ).stdout.strip()
    begin = last = time.monotonic()
    made = 0
    for seed, F in zip(missing, runs(text, problem, missing, evaluations), strict=False):
        now = time.monotonic()
        common = {"problem": name, "algorithm": text, "space": space, "seed": seed}
        common |= {"seconds": f"{now - last:.1f}", "commit": commit, "pymoo": pymoo.__version__}
        rows = []
        for n in budgets:
            value, points = scale.hypervolume(F[:n])
            rows.append(
                common | {"evaluations": n, "hypervolume": f"{value:.6f}", "points": points}
            )
        append(path, rows)
        made += 1
        last = time.monotonic()
        if last - begin > seconds:
            break
    return made


def seeds_of(text: str) -> list[int]:
    """The seeds of "1-20" or "3"."""
    first, _, last = text.partition("-")
    return list(range(int(first), int(last or first) + 1))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("table", type=Path)
    parser.add_argument("--problem", default="attitude")
    parser.add_argument("--algorithm", required=True)
    parser.add_argument("--space", default=RAW, choices=(RAW, INDICATOR))
    parser.add_argument("--seeds", type=seeds_of, default=seeds_of("1-20"))
    parser.add_argument("--evaluations", type=int, default=max(BUDGETS))
    parser.add_argument("--seconds", type=float, default=150.0, help="stop after this long")
    given = parser.parse_args()
    made = record(
        given.table, given.problem, given.algorithm, given.space, given.seeds, given.evaluations,
        given.seconds,
    )  # fmt: skip
    print(f"{given.problem} {given.algorithm} {given.space}: {made} runs made")


if __name__ == "__main__":
    main()
