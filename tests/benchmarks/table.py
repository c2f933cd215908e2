"""Measure the filter step and write the table of docs/performance.md.

    python -m tests.benchmarks.table

Run it in the root of the repository on an idle machine; it takes a minute.
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
from .pages import DOCS, markdown, write_table

#: Rounds of which the fastest counts.
ROUNDS = 9


def main() -> None:
    tables = "\n\n".join(
        (
            circumstances(),
            step_table(speed.compare(speed.step_tasks(), ROUNDS)),
            growth_table(speed.compare(speed.growth_tasks(), ROUNDS)),
        )
    )
    write_table(DOCS / "performance.md", "measured tables", tables)
    print(tables)


def circumstances() -> str:
    """Return processor, versions and date of the measurement as one line."""
    versions = ", ".join(
        f"{package} {version(package)}" for package in ("numpy", "numba", "llvmlite", "filterpy")
    )
    return (
        f"{processor()} ({llvmlite.binding.get_host_cpu_name()}), {platform.system()}, Python "
        f"{platform.python_version()}, {versions}; {datetime.now(UTC):%Y-%m-%d}; best of {ROUNDS} "
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
