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
    """A line for each preset and search."""
    yield (
        "| preset | search | CPU time, least [s] | hypervolume predicted | kept "
        "| kept / predicted t_end: median | greatest | more than 20 % late |"
    )
    yield "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |"
    for preset in PRESETS:
        for search in SEARCHES:
            if not (each := of(rows, preset, search)):
                continue
            median, greatest = column(each, "ratio").T
            late = 100.0 * column(each, "late").mean()
            yield (
                f"| {preset} | {search} | {column(each, 'processor_s').min():.0f} "
                f"| {column(each, 'promised').mean():.4f} | {column(each, 'kept').mean():.4f} "
                f"| {np.mean(median):.2f} | {greatest.max():.2f} | {late:.1f} % |"
            )


def tests(rows: Rows) -> Iterator[str]:
    """p of what is kept, against the robust search, by Holm for the searches of a preset."""
    for preset in PRESETS:
        kept = {search: column(of(rows, preset, search), "kept") for search in SEARCHES}
        if min(map(len, kept.values())) < LEAST:
            continue
        others = [search for search in kept if search != "robust"]
        p = holm([mann_whitney(kept["robust"], kept[each]) for each in others])
        yield f"{preset}: " + ", ".join(
            f"{search} p = {value:.2g}" for search, value in zip(others, p, strict=True)
        )


def draw(rows: Rows) -> None:
    """Write the picture: fronts of seed 1, as promised and as kept."""
    mpl.rcParams["svg.hashsalt"] = "robust"
    figure = Figure(figsize=(10.0, 4.2), layout="constrained")
    for axes, preset in zip(figure.subplots(1, 2), PRESETS, strict=True):
        for search, color in SHOWN.items():
            for row in of(rows, preset, search):
                for front, style, what in zip(
                    row["fronts"], (":", "-"), ("predicted", "0.9-quantile"), strict=False
                ):
                    time, trace = np.array(front).T
                    label = f"{search}, {what}"
                    axes.step(time, trace, style, color=color, where="post", label=label)
        axes.set(title=preset, yscale="log", xlabel="t_end [s]", ylabel="trace [-]")
        axes.legend(frameon=False)
    figure.savefig(PICTURE, metadata={"Date": None})


def main() -> None:
    """Write both, and print the tests."""
    rows = stored()
    print(*tests(rows), sep="\n")
    text = with_table(PAGE.read_text(encoding="utf-8"), "searches", "\n".join(table(rows)))
    PAGE.write_text(text, encoding="utf-8")
    draw(rows)


if __name__ == "__main__":
    main()
