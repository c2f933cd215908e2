"""Measure the filter step and write the table of docs/performance.md.

    python -m tests.benchmarks.table

Run it in the root of the repository on an idle machine; it takes a minute.
"""

from __future__ import annotations

import argparse
import platform
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import llvmlite.binding

from . import cases, speed
from .measure import Timing

DOCUMENT = Path(__file__).parents[2] / "docs" / "performance.md"
BEGIN, END = "<!-- begin of measured tables -->", "<!-- end of measured tables -->"


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="Measure and write docs/performance.md.")
    parser.add_argument("--rounds", type=int, default=9, help="rounds to take the best of")
    rounds = parser.parse_args(arguments).rounds
    text = DOCUMENT.read_text(encoding="utf-8")
    tables = "\n\n".join(
        (
            circumstances(rounds),
            step_table(speed.compare(speed.step_tasks(), rounds)),
            growth_table(speed.compare(speed.growth_tasks(), rounds)),
        )
    )
    DOCUMENT.write_text(with_tables(text, tables), encoding="utf-8")
    print(tables)


def with_tables(text: str, tables: str) -> str:
    """Return the document with everything between the two markers replaced."""
    head, found_begin, rest = text.partition(BEGIN)
    _, found_end, tail = rest.partition(END)
    if not (found_begin and found_end):
        raise ValueError(f"expected the lines {BEGIN!r} and {END!r} in the document")
    return f"{head}{BEGIN}\n{tables}\n{END}{tail}"


def circumstances(rounds: int) -> str:
    """Return processor, versions and date of the measurement as one line."""
    versions = ", ".join(
        f"{package} {version(package)}" for package in ("numpy", "numba", "llvmlite", "filterpy")
    )
    return (
        f"{processor()} ({llvmlite.binding.get_host_cpu_name()}), {platform.system()}, Python "
        f"{platform.python_version()}, {versions}; {datetime.now(UTC):%Y-%m-%d}; best of {rounds} "
        "rounds, CPU time per thread."
    )


def step_table(measured: Mapping[str, Timing]) -> str:
    slowest = measured["filterpy"].processor
    rows = [
        (name, f"{1e9 * timing.processor:,.0f}", f"{slowest / timing.processor:.1f}")
        for name, timing in measured.items()
    ]
    return markdown(("one step, 18 states", "ns", "times faster than filterpy"), rows)


def growth_table(measured: Mapping[str, Timing]) -> str:
    rows = [
        (name, cases.model(name).suite.n_states, f"{1e9 * timing.processor:.0f}")
        for name, timing in measured.items()
    ]
    return markdown(("suite", "states", "kernel [ns]"), rows)


def markdown(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table whose first column is text and whose others are numbers."""
    rule = ["---", *["---:"] * (len(head) - 1)]
    return "\n".join(f"| {' | '.join(map(str, row))} |" for row in (head, rule, *rows))


def processor() -> str:
    """Return the name of the processor."""
    information = Path("/proc/cpuinfo")
    if information.exists():
        for line in information.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


if __name__ == "__main__":
    main()
