"""Measures everything and writes the tables of docs/performance.md.

    python -m tests.benchmarks.table

Run it in the repository's root, on an idle machine, for a few minutes.
"""

from __future__ import annotations

import argparse
import platform
import sys
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import llvmlite.binding
from mgeo_attitude.filter.kernel import lanes

from . import cases, speed
from .count import Count, count_step
from .speed import Comparison, Speed

DOCUMENT = Path(__file__).parents[2] / "docs" / "performance.md"
BEGIN, END = "<!-- begin of measured tables -->", "<!-- end of measured tables -->"

#: Of the designs of the table by size of the problem.
_MANEUVERS = 3
_VECTORS = {"avx512f": "AVX-512", "avx2": "AVX2", "neon": "NEON"}


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="Measure and write docs/performance.md.")
    parser.add_argument("--rounds", type=int, default=9, help="rounds to take the best of")
    parser.add_argument("--output", type=Path, default=DOCUMENT, help="document with the markers")
    options = parser.parse_args(arguments)
    text = options.output.read_text(encoding="utf-8")
    tables = measured_tables(options.rounds)
    sys.stdout.write(f"{tables}\n\nBy size of the problem, 360 designs on one thread:\n\n")
    growth = speed.compare(speed.growth_tasks(), options.rounds)
    sys.stdout.write(f"{growth_table(growth)}\n")
    options.output.write_text(with_tables(text, tables), encoding="utf-8")


def with_tables(text: str, tables: str) -> str:
    """The document with everything between the two markers replaced."""
    head, found_begin, rest = text.partition(BEGIN)
    _, found_end, tail = rest.partition(END)
    if not (found_begin and found_end):
        raise ValueError(f"expected the lines {BEGIN!r} and {END!r} in the document")
    return f"{head}{BEGIN}\n{tables}\n{END}{tail}"


def measured_tables(rounds: int) -> str:
    """The page's table and the circumstances it was measured in, as Markdown."""
    step = speed.compare(speed.step_tasks(), rounds)
    parts = [
        circumstances(rounds),
        f"One core does {step.peak:.1f} multiply-adds per ns at most (measured). A step of the "
        f"paper's suite needs {_paper().multiplications}, that is at least "
        f"{_paper().multiplications / step.peak:.0f} ns ({_paper().flops} operations in all).",
        step_table(step),
    ]
    return "\n\n".join(parts)


def circumstances(rounds: int) -> str:
    versions = ", ".join(
        f"{package} {version(package)}" for package in ("numpy", "numba", "llvmlite", "filterpy")
    )
    return (
        f"{processor()} ({llvmlite.binding.get_host_cpu_name()}, {_vector_extension()}), "
        f"{lanes()} lanes, {platform.system()}, Python {platform.python_version()}, {versions}; "
        f"{datetime.now(UTC):%Y-%m-%d}; best of {rounds} rounds."
    )


def step_table(measured: Comparison[str]) -> str:
    count, slowest = _paper(), measured.speeds["filterpy"].processor
    rows = [
        (
            name,
            f"{it.processor:,.0f}",
            f"{slowest / it.processor:.1f}",
            f"{measured.fraction_of_peak(name, count):.1%}",
        )
        for name, it in measured.speeds.items()
    ]
    return markdown(
        ("one step, 18 states", "ns", "times faster than filterpy", "of the multiply-add peak"),
        rows,
    )


def growth_table(measured: Comparison[tuple[str, int, str]]) -> str:
    rows = []
    for name, maneuvers, way in measured.speeds:
        if way != "kernel" or maneuvers != _MANEUVERS:
            continue
        model = cases.model(name)
        loop: Speed | None = measured.speeds.get((name, maneuvers, "scalar loop"))
        it = measured.speeds[name, maneuvers, "kernel"]
        rows.append(
            (
                name,
                model.suite.n_states,
                f"{loop.processor:.0f}" if loop else "-",
                f"{it.processor:.0f}",
                f"{loop.processor / it.processor:.1f}" if loop else "-",
                f"{measured.fraction_of_peak((name, maneuvers, way), count_step(model)):.0%}",
            )
        )
    head = ("suite", "states", "scalar loop [ns]", "kernel [ns]", "ratio", "of peak")
    return markdown(head, rows)


def _paper() -> Count:
    return count_step(cases.model(cases.PAPER))


def markdown(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    rule = ["---", *["---:"] * (len(head) - 1)]
    return "\n".join(f"| {' | '.join(map(str, row))} |" for row in (head, rule, *rows))


def processor() -> str:
    """The processor's name, where the operating system tells it."""
    information = Path("/proc/cpuinfo")
    if information.exists():
        for line in information.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _vector_extension() -> str:
    features = llvmlite.binding.get_host_cpu_features()
    names = [name for feature, name in _VECTORS.items() if features.get(feature)]
    return names[0] if names else platform.machine()


if __name__ == "__main__":
    main()
