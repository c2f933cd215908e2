"""Measure the filter step and write the tables of docs/validation/performance.md.

Run ``python -m tests.benchmarks.table`` in the root of the repository on an idle machine. It takes
a minute.
"""

from __future__ import annotations

import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import llvmlite.binding

from . import cases, speed
from .measure import Timing
from .pages import DOCS, format_table, write_table

#: Number of rounds; the fastest round counts.
ROUNDS = 9


def main() -> None:
    tables = "\n\n".join(
        (
            describe_measurement(),
            format_step_table(speed.time_tasks(speed.build_step_tasks(), ROUNDS)),
            format_growth_table(speed.time_tasks(speed.build_growth_tasks(), ROUNDS)),
        )
    )
    write_table(DOCS / "validation/performance.md", "measured tables", tables)
    print(tables)


def describe_measurement() -> str:
    """Return processor, versions and date of the measurement as one line."""
    versions = ", ".join(
        f"{package} {version(package)}" for package in ("numpy", "numba", "llvmlite", "filterpy")
    )
    return (
        f"{get_processor_name()} ({llvmlite.binding.get_host_cpu_name()}), {platform.system()}, "
        f"Python {platform.python_version()}, {versions}; {datetime.now(UTC):%Y-%m-%d}; best of "
        f"{ROUNDS} rounds, CPU time per thread."
    )


def format_step_table(measured: Mapping[str, Timing]) -> str:
    slowest = measured["filterpy"].processor
    rows = [
        (name, f"{1e9 * timing.processor:,.0f}", f"{slowest / timing.processor:.1f}")
        for name, timing in measured.items()
    ]
    return format_table(("one step, 18 states", "ns", "times faster than filterpy"), rows)


def format_growth_table(measured: Mapping[str, Timing]) -> str:
    rows = [
        (name, cases.build_model(name).suite.n_states, f"{1e9 * timing.processor:.0f}")
        for name, timing in measured.items()
    ]
    return format_table(("suite", "states", "kernel [ns]"), rows)


def get_processor_name() -> str:
    information = Path("/proc/cpuinfo")
    if information.exists():
        for line in information.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


if __name__ == "__main__":
    main()
