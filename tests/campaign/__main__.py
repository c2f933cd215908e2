"""Makes cases and tells how they went."""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterable, Sequence

from . import kinds
from .harness import Result, run_case


def campaign(
    numbers: Iterable[int], among: Sequence[str] = (), every: float = 10.0
) -> list[Result]:
    """Make the cases, with a line of progress now and then; those that went wrong."""
    made: Counter[str] = Counter()
    refused: Counter[str] = Counter()
    spent: Counter[str] = Counter()
    failed: list[Result] = []
    shown = began = time.monotonic()
    for number in numbers:
        start = time.process_time()
        result = run_case(number, among)
        spent[result.kind] += time.process_time() - start
        made[result.kind] += 1
        refused[result.kind] += result.refused
        if result.failures:
            failed.append(result)
            _tell(result, among)
        if time.monotonic() - shown > every:
            shown = time.monotonic()
            total = sum(made.values())
            print(f"{total} cases in {shown - began:.0f} s, {len(failed)} failed", flush=True)
    print(f"{'kind':32} {'cases':>7} {'refused':>8} {'failed':>7} {'ms/case':>8}")
    wrong = Counter(result.kind for result in failed)
    for kind in sorted(made):
        pace = 1e3 * spent[kind] / made[kind]
        print(f"{kind:32} {made[kind]:7} {refused[kind]:8} {wrong[kind]:7} {pace:8.1f}")
    total = sum(made.values())
    print(f"{'all':32} {total:7} {refused.total():8} {len(failed):7} "
          f"{1e3 * spent.total() / max(total, 1):8.1f}")  # fmt: skip
    return failed


def main() -> int:
    """The command: 1 if a case went wrong."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaign", description=__doc__)
    parser.add_argument("--cases", type=int, default=1000, help="how many")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--case", type=int, help="only this one, with all it did")
    parser.add_argument("--kind", choices=kinds.KINDS, help="only of this kind")
    parser.add_argument("--cheap", action="store_true", help="only of those that run no command")
    parser.add_argument("--keep", action="store_true", help="with --case: keep its folder")
    given = parser.parse_args()
    among = (given.kind,) if given.kind else kinds.CHEAP if given.cheap else ()
    if given.case is not None:
        result = run_case(given.case, among, given.keep)
        print(f"case {result.number}: {result.kind}", *result.log, sep="\n  ")
        print("refused with" if result.refused else "said", repr(result.said))
        print(*(result.failures or ["as it should be"]), sep="\n")
        return int(bool(result.failures))
    failed = campaign(range(given.first, given.first + given.cases), among)
    return int(bool(failed))


def _tell(result: Result, among: Sequence[str]) -> None:
    more = " --cheap" if tuple(among) == kinds.CHEAP else "".join(f" --kind '{k}'" for k in among)
    print(f"\npython -m tests.campaign --case {result.number}{more}   ({result.kind})")
    print("  " + result.failures[0].strip()[-1200:].replace("\n", "\n  "), flush=True)


if __name__ == "__main__":
    sys.exit(main())
