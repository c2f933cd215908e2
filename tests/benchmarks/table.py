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

_VECTORS = {"avx512f": "AVX-512", "avx2": "AVX2", "neon": "NEON"}


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="Measure and write docs/performance.md.")
    parser.add_argument("--rounds", type=int, default=9, help="rounds to take the best of")
    parser.add_argument("--output", type=Path, default=DOCUMENT, help="document with the markers")
    options = parser.parse_args(arguments)
    text = options.output.read_text(encoding="utf-8")
    tables = measured_tables(options.rounds)
    sys.stdout.write(f"{tables}\n")
    options.output.write_text(with_tables(text, tables), encoding="utf-8")


def with_tables(text: str, tables: str) -> str:
    """The document with everything between the two markers replaced."""
    head, found_begin, rest = text.partition(BEGIN)
    _, found_end, tail = rest.partition(END)
    if not (found_begin and found_end):
        raise ValueError(f"expected the lines {BEGIN!r} and {END!r} in the document")
    return f"{head}{BEGIN}\n{tables}\n{END}{tail}"


def measured_tables(rounds: int) -> str:
    """All tables and the circumstances they were measured in, as Markdown."""
    step = speed.compare(speed.step_tasks(), rounds)
    batch_rounds = max(3, rounds // 3)  # the largest takes seconds
    batch = speed.compare(speed.batch_tasks(), batch_rounds)
    growth = speed.compare(speed.growth_tasks(), rounds)
    parts = [
        circumstances(rounds, batch.undisturbed),
        f"One core does {step.peak:.1f} multiply-adds per ns at most (measured). A step of the "
        f"paper's suite needs {_paper().multiplications}, that is at least "
        f"{_paper().multiplications / step.peak:.0f} ns ({_paper().flops} operations in all).",
        step_table(step),
        f"By size of the batch, paper's suite, best of {batch_rounds} rounds:",
        batch_table(batch),
        "By size of the problem, 360 designs on one thread:",
        growth_table(growth),
    ]
    return "\n\n".join(parts)


def circumstances(rounds: int, undisturbed: bool) -> str:
    versions = ", ".join(
        f"{package} {version(package)}" for package in ("numpy", "numba", "llvmlite", "filterpy")
    )
    busy = (
        ""
        if undisturbed
        else " Other programs were running, so speed-ups by the clock are left out."
    )
    return (
        f"{processor()} ({llvmlite.binding.get_host_cpu_name()}, {_vector_extension()}), "
        f"{lanes()} lanes, {platform.system()}, Python {platform.python_version()}, {versions}; "
        f"{datetime.now(UTC):%Y-%m-%d}; best of {rounds} rounds.{busy}"
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


def batch_table(measured: Comparison[tuple[str, int]]) -> str:
    rows = []
    for (batch, threads), it in measured.speeds.items():
        one = measured.speeds[batch, 1]
        told = threads > 1 and measured.undisturbed
        gain = f"{one.wall / it.wall:.2f}" if told else "-"
        rows.append((batch, threads, f"{it.processor:,.0f}", gain))
    head = ("designs", "threads", "ns per step and thread", "speed-up by the clock")
    return markdown(head, rows)


def growth_table(measured: Comparison[tuple[str, int, str]]) -> str:
    rows = []
    for name, maneuvers, way in measured.speeds:
        if way != "kernel":
            continue
        model = cases.model(name)
        count = count_step(model)
        loop: Speed | None = measured.speeds.get((name, maneuvers, "scalar loop"))
        it = measured.speeds[name, maneuvers, "kernel"]
        rows.append(
            (
                name,
                model.suite.n_states,
                len(model.suite.sensors),
                maneuvers,
                count.multiplications,
                f"{loop.processor:.0f}" if loop else "-",
                f"{it.processor:.0f}",
                f"{loop.processor / it.processor:.1f}" if loop else "-",
                f"{measured.fraction_of_peak((name, maneuvers, way), count):.0%}",
            )
        )
    head = (
        "suite",
        "states",
        "sensors",
        "maneuvers",
        "multiply-adds",
        "scalar loop [ns]",
        "kernel [ns]",
        "ratio",
        "of peak",
    )
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
