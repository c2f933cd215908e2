"""Writes the table and the picture of docs/robust.md from docs/robust.jsonl.

    python -m tests.benchmarks.robust_document

Run it in the repository's root.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from mgeo.studies.statistics import holm, mann_whitney

from .consistency_document import with_table
from .robust import PRESETS, ROOT, SEARCHES, stored

PAGE = ROOT / "docs" / "robust.md"
PICTURE = ROOT / "docs" / "images" / "robust.svg"
#: What the picture shows of whom: promised and kept.
SHOWN = {"nominal": "#D55E00", "robust": "#0072B2"}
#: Fewer seeds than this have no test.
LEAST = 5

Rows = list[dict[str, Any]]


def of(rows: Rows, preset: str, search: str) -> Rows:
    """Those of a preset and search."""
    return [row for row in rows if row["key"][:2] == [preset, search]]


def column(rows: Rows, name: str) -> np.ndarray:
    """A number of each row."""
    return np.array([row[name] for row in rows])


def table(rows: Rows) -> Iterator[str]:
    """A line for each preset and search; p is of what is kept, against the robust search."""
    yield (
        "| preset | search | seeds | CPU time, least [s] | hypervolume promised | kept "
        "| p (Holm) | kept / promised t_end: median | greatest | plans late by more than a fifth |"
    )
    yield "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"
    for preset in PRESETS:
        found = {search: of(rows, preset, search) for search in SEARCHES}
        kept = {search: column(each, "kept") for search, each in found.items() if each}
        others = [search for search in kept if search != "robust"]
        enough = kept and min(map(len, kept.values())) >= LEAST
        p = holm([mann_whitney(kept["robust"], kept[each]) for each in others]) if enough else []
        told = dict(zip(others, p, strict=False))
        for search, values in kept.items():
            each = found[search]
            median, greatest = column(each, "ratio").T
            yield (
                f"| {preset} | {search} | {len(each)} | {column(each, 'processor_s').min():.0f} "
                f"| {column(each, 'promised').mean():.4f} | {values.mean():.4f} "
                f"| {f'{told[search]:.2g}' if search in told else ''} | {np.mean(median):.2f} "
                f"| {greatest.max():.2f} | {100.0 * column(each, 'late').mean():.1f} % |"
            )


def draw(rows: Rows) -> None:
    """Write the picture: fronts of seed 1, as promised and as kept."""
    mpl.rcParams["svg.hashsalt"] = "robust"
    figure = Figure(figsize=(10.0, 4.2), layout="constrained")
    for axes, preset in zip(figure.subplots(1, 2), PRESETS, strict=True):
        for search, color in SHOWN.items():
            for row in of(rows, preset, search):
                for front, style, what in zip(
                    row["fronts"], (":", "-"), ("promised", "kept by 9 of 10 flights"), strict=False
                ):
                    time, trace = np.array(front).T
                    label = f"{search}, {what}"
                    axes.step(time, trace, style, color=color, where="post", label=label)
        axes.set(title=preset, yscale="log", xlabel="t_end [s]", ylabel="trace [-]")
        axes.legend(frameon=False)
    figure.savefig(PICTURE, metadata={"Date": None})


def main() -> None:
    """Write both."""
    rows = stored()
    text = with_table(PAGE.read_text(encoding="utf-8"), "searches", "\n".join(table(rows)))
    PAGE.write_text(text, encoding="utf-8")
    draw(rows)


if __name__ == "__main__":
    main()
