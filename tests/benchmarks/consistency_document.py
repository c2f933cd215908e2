"""Writes table and picture of docs/consistency.md from docs/consistency.jsonl, prints the plans'.

    python -m tests.benchmarks.consistency_document

Run it in the repository's root.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from .consistency import DEFAULT, ESTIMATORS, LARGE, PLANS, ROOT, SWEEPS, stored

DOCUMENT = ROOT / "docs" / "consistency.md"
PICTURE = ROOT / "docs" / "images" / "consistency.svg"

HOPELESS = 30.0
#: Estimators that the page compares; the others are in the data.
SHOWN = [name for name in ESTIMATORS if name not in ("Jacobians", "Jacobians, second order")]

Results = dict[str, dict[str, Any]]


def main() -> None:
    results = {row["key"]: row for row in stored()}
    text = DOCUMENT.read_text(encoding="utf-8")
    text = with_table(text, "remedies", "\n".join(remedies_table(results)))
    print(*plans_table(results), sep="\n")
    DOCUMENT.write_text(text, encoding="utf-8")
    draw(results, PICTURE)


def with_table(text: str, name: str, table: str) -> str:
    """The text with what is between the markers of a name replaced."""
    begin, end = f"<!-- begin of {name} -->", f"<!-- end of {name} -->"
    before, found, rest = text.partition(begin)
    _, closed, after = rest.partition(end)
    if not found or not closed:
        raise ValueError(f"{DOCUMENT}: expected the markers {begin} and {end}")
    return f"{before}{begin}\n{table}\n{end}{after}"


def plans_table(results: Results) -> Iterator[str]:
    yield "| scenario | t_end [s] | NEES | beyond 3σ | RMS / predicted | |"
    yield "| --- | ---: | ---: | ---: | --- | --- |"
    for name, plans in PLANS["scenarios"].items():
        for i in range(len(plans)):
            row = results[f"plans/{name}/{i}"]
            c = row["criteria"]
            failed = [k for k, (value, low, high) in c.items() if not low <= value <= high]
            ratios = " to ".join(
                f"{c[f'{e} rms / predicted'][0]:.2f}" for e in ("smallest", "largest")
            )
            yield (
                f"| {name} | {row['t_end']:.0f} | {c['nees'][0]:.3f} | "
                f"{c['beyond 3 sigma'][0]:.0f} | {ratios} | "
                f"{'fails: ' + ', '.join(failed) if failed else 'passes'} |"
            )


def remedies_table(results: Results) -> Iterator[str]:
    yield "| | " + " | ".join(f"{name} | RMS / predicted" for name in ("cubesat_6u", LARGE)) + " |"
    yield "| --- | ---: | ---: | ---: | ---: |"
    for label in SHOWN:
        cells = []
        for name in ("cubesat_6u", LARGE):
            row = results[f"remedies/{name}/{label}"]
            c = row["criteria"]
            cells += [
                f"{row['nees_first_300s']:.2f}, {c['nees'][0]:.2f}",
                f"{c['largest rms / predicted'][0]:.2f}",
            ]
        name = f"**{label}**" if label == DEFAULT else label
        yield f"| {name} | {' | '.join(cells)} |"


def nees(results: Results, name: str, what: str, value: float, label: str) -> float:
    return float(results[f"map/{name}/{what}/{value:g}/{label}"]["criteria"]["nees"][0])


def draw(results: Results, path: Path) -> None:
    """NEES over every swept uncertainty, both scenarios and estimators."""
    low, high = next(
        row["criteria"]["nees"][1:] for key, row in results.items() if key.startswith("map/")
    )
    with mpl.rc_context({"svg.hashsalt": "consistency", "font.size": 9}):
        figure = Figure(figsize=(9.0, 3.2), layout="constrained")
        panels = figure.subplots(1, len(SWEEPS), sharey=True)
        for panel, (what, values) in zip(panels, SWEEPS.items(), strict=True):
            panel.axhspan(low, high, color="0.88")
            for name, color in (("paper", "tab:blue"), ("cubesat_6u", "tab:orange")):
                for label, line in (("plain", "--"), (DEFAULT, "-")):
                    y = [nees(results, name, what, value, label) for value in values]
                    text = f"{name}, {'plain' if label == 'plain' else 'as shipped'}"
                    panel.plot(values, y, line, marker=".", color=color, label=text)
            panel.set(xscale="log", yscale="log", xlabel=f"initial {what}, 1σ per axis")
            panel.set_xticks(values, [f"{value:g}" for value in values])
            panel.minorticks_off()
        panels[0].set_ylabel("NEES per state, 2nd half of an orbit")
        panels[0].set_ylim(0.8, HOPELESS)
        panels[0].set_yticks([1, 2, 5, 10, 20], ["1", "2", "5", "10", "20"])
        panels[0].legend(fontsize=8)
        figure.savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    main()
