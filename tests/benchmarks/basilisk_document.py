"""Writes table and picture of docs/basilisk.md from docs/basilisk.jsonl, and prints the plans'.

    python -m tests.benchmarks.basilisk_document

Run it in the repository's root.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from scipy.stats import chi2, norm

from .basilisk import PLANS, ROOT, problem, stored
from .consistency_document import with_table

DOCUMENT = ROOT / "docs" / "basilisk.md"
PICTURE = ROOT / "docs" / "images" / "basilisk.svg"

WHEN = ("at t_end", "at the end")
#: Means of chi-squares outside of these are too far off to be chance, with 99 %.
BOUNDS = (0.005, 0.995)

Rows = list[dict[str, Any]]


def main() -> None:
    rows = [row for row in stored() if "errors" in row]
    print(*plans_table(rows), sep="\n")
    text = DOCUMENT.read_text(encoding="utf-8")
    text = with_table(text, "blocks", "\n".join(blocks_table(rows)))
    DOCUMENT.write_text(text, encoding="utf-8")
    draw(rows)


def of(rows: Rows, name: str, when: str, number: int | None = None) -> Rows:
    """The flights of a plan, or of all of a scenario."""
    return [
        row
        for row in rows
        if (row["key"][0], row["key"][3]) == (name, when) and number in (None, row["key"][1])
    ]


def table(rows: Rows, key: str) -> np.ndarray:
    return np.array([row[key] for row in rows])


def band(n: int) -> tuple[float, float]:
    """Where the mean of n squares of standard normal numbers is."""
    low, high = chi2.ppf(BOUNDS, n) / n
    return float(low), float(high)


def plans_table(rows: Rows) -> Iterator[str]:
    yield (
        "| scenario | until [s] | flights | NEES per state (99 % bounds) | errors beyond 3σ "
        "(expected) | RMS error / claimed | claimed / predicted | supported |"
    )
    yield "| --- | ---: | ---: | --- | --- | ---: | --- | ---: |"
    for name, plans in PLANS.items():
        for number in range(len(plans)):
            for when in WHEN:
                found = of(rows, name, when, number)
                z = table(found, "errors") / table(found, "sigma")
                nees = table(found, "nees").sum() / z.size
                low, high = band(z.size)
                ratio = np.median(table(found, "sigma") / table(found, "promised"), axis=0)
                yield (
                    f"| {name} | {found[0]['t']:.0f} | {len(found)} | {nees:.3f} "
                    f"({low:.3f} to {high:.3f}){'' if low < nees < high else ' **out**'} | "
                    f"{(np.abs(z) > 3).sum()} ({2 * norm.sf(3) * z.size:.1f}) | "
                    f"{np.sqrt((z**2).mean()):.3f} | {ratio.min():.2f} to {ratio.max():.2f} | "
                    f"{sum(row['supported'] for row in found)} of {len(found)} |"
                )


def blocks_table(rows: Rows) -> Iterator[str]:
    yield "| | " + " | ".join(f"{name}, {when}" for name in PLANS for when in WHEN) + " |"
    yield "| --- |" + " ---: |" * (len(PLANS) * len(WHEN))
    for i, block in enumerate(problem("paper").model.suite.blocks):
        cells = []
        for name in PLANS:
            for when in WHEN:
                found, part = of(rows, name, when), slice(3 * i, 3 * i + 3)
                e = table(found, "errors")[:, part]
                ratios = [
                    np.sqrt(((e / table(found, key)[:, part]) ** 2).mean())
                    for key in ("sigma", "promised")
                ]
                cells.append(f"{ratios[0]:.2f}, {ratios[1]:.2f}")
        yield f"| {block} | {' | '.join(cells)} |"
    n = 3 * len(of(rows, "paper", WHEN[0]))
    low, high = np.sqrt(band(n))
    yield (
        f"| *99 % of perfect ones, {n} errors* | "
        + " | ".join([f"*{low:.2f} to {high:.2f}*"] * 4)
        + " |"
    )


def draw(rows: Rows) -> None:
    """Every error over its claimed 1-sigma, by block."""
    blocks = problem("paper").model.suite.blocks
    with mpl.rc_context({"svg.hashsalt": "basilisk", "font.size": 9}):
        figure = Figure(figsize=(9.0, 3.2), layout="constrained")
        panels = figure.subplots(1, len(PLANS), sharey=True)
        for panel, name in zip(panels, PLANS, strict=True):
            found = of(rows, name, WHEN[1])
            z = table(found, "errors") / table(found, "sigma")
            panel.axhspan(-3, 3, color="0.92")
            panel.axhspan(-1, 1, color="0.84")
            scatter = np.linspace(-0.3, 0.3, len(z))
            for i in range(len(blocks)):
                for axis, color in enumerate(("tab:red", "tab:green", "tab:blue")):
                    at, values = i + scatter, z[:, 3 * i + axis]
                    panel.plot(at, values, ".", color=color, ms=3, label="xyz"[axis])
            panel.set_xticks(range(len(blocks)), blocks, rotation=20, ha="right")
            panel.set_title(f"{name}, {len(z)} flights of two orbits")
        panels[0].set_ylabel("error / 1σ claimed")
        handles, labels = panels[0].get_legend_handles_labels()
        panels[0].legend(handles[:3], labels[:3], ncols=3, fontsize=8)
        figure.savefig(PICTURE, metadata={"Date": None})


if __name__ == "__main__":
    main()
