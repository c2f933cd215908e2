"""The tables of docs/experiments/README.md, from the recorded runs.

python -m tests.benchmarks.variant.tables
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd

from mgeo.studies.statistics import holm, mann_whitney, vargha_delaney

from .record import BUDGETS

FOLDER = Path(__file__).parents[3] / "docs" / "experiments"
OURS = "mgeo-directed"
RIVALS = ("nsga2", "sms-emoa", "spea2", "age-moea2", "gde3", "moead", "cmopso")


def read(name: str) -> pd.DataFrame:
    """A table of runs; of a run recorded twice, the later one."""
    table = pd.read_csv(FOLDER / name)
    return table.drop_duplicates(
        ["problem", "algorithm", "space", "seed", "evaluations"], keep="last"
    )


def values(table: pd.DataFrame, algorithm: str, space: str, evaluations: int) -> np.ndarray:
    """Hypervolumes, one a seed."""
    chosen = table[
        (table["algorithm"] == algorithm)
        & (table["space"] == space)
        & (table["evaluations"] == evaluations)
    ]
    return chosen["hypervolume"].to_numpy(float)


def shown(sample: np.ndarray) -> str:
    """Mean, standard deviation and number of runs."""
    if not len(sample):
        return "-"
    deviation = f" ± {sample.std(ddof=1):.4f}" if len(sample) > 1 else ""
    return f"{sample.mean():.4f}{deviation} ({len(sample)})"


def bar(table: pd.DataFrame) -> list[list[str]]:
    """Every algorithm on either form of the objectives."""
    rows = []
    pairs = table[["algorithm", "space"]].drop_duplicates().sort_values(["algorithm", "space"])
    for algorithm, space in pairs.itertuples(index=False):
        cells = [shown(values(table, algorithm, space, n)) for n in BUDGETS]
        rows.append([algorithm, space, *cells])
    return [["algorithm", "objectives", *(f"{n:,}" for n in BUDGETS)], *rows]


def against(table: pd.DataFrame, evaluations: int) -> list[list[str]]:
    """Ours against each rival's better form, with p values corrected by Holm for all rivals."""
    ours = values(table, OURS, "raw", evaluations)
    rows, p = [], []
    for rival in RIVALS:
        forms = {space: values(table, rival, space, evaluations) for space in ("raw", "indicator")}
        forms = {space: sample for space, sample in forms.items() if len(sample)}
        if not forms or not len(ours):
            continue
        space = max(forms, key=lambda form: forms[form].mean())
        theirs = forms[space]
        p.append(mann_whitney(ours, theirs))
        gain = ours.mean() - theirs.mean()
        rows.append(
            [rival, space, shown(theirs), f"{gain:+.4f}", f"{vargha_delaney(ours, theirs):.2f}"]
        )
    for row, corrected in zip(rows, holm(p) if p else [], strict=True):
        row.append(f"{corrected:.2g}")
    title = f"{OURS} {shown(ours)}"
    return [[title, "objectives", "its hypervolume", "ours higher by", "A", "p (Holm)"], *rows]


def ablation(table: pd.DataFrame) -> list[list[str]]:
    """Every way to run ours that was recorded, best first, against the default."""
    budgets = [n for n in BUDGETS if (table["evaluations"] == n).any()]
    names = sorted(
        table["algorithm"].unique(), key=lambda a: -values(table, a, "raw", budgets[-1]).mean()
    )
    rows = []
    for name in names:
        sample, default = (values(table, a, "raw", budgets[-1]) for a in (name, OURS))
        p = "" if name == OURS or not len(default) else f"{mann_whitney(sample, default):.2g}"
        label = name.partition(":")[2] or ("as shipped" if name == OURS else name)
        rows.append([label, *(shown(values(table, name, "raw", n)) for n in budgets), p])
    return [["changed", *(f"{n:,}" for n in budgets), "p"], *rows]


def elsewhere(table: pd.DataFrame) -> list[list[str]]:
    """Mean hypervolume on test problems; in bold the best of several."""
    names = [OURS, *sorted(set(table["algorithm"]) - {OURS})]
    rows = []
    for problem, runs in table.groupby("problem", sort=True):
        n = int(runs["evaluations"].max())
        means = {a: values(runs, a, "raw", n) for a in names}
        known = [sample.mean() for sample in means.values() if len(sample)]
        best = max(known) if len(known) > 1 else np.inf
        cells = []
        for sample in means.values():
            text = f"{sample.mean():.4f}" if len(sample) else "-"
            cells.append(f"**{text}**" if len(sample) and sample.mean() == best else text)
        rows.append([str(problem), f"{n:,}", *cells])
    return [["problem", "evaluations", *names], *rows]


def markdown(rows: Iterable[list[str]]) -> str:
    """A table; its first row is the header."""
    header, *body = rows
    lines = [header, ["---"] * len(header), *body]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def fill(text: str, tables: dict[str, str]) -> str:
    """Put tables between their marks, <!-- name --> and <!-- end -->."""
    for name, table in tables.items():
        pattern = rf"(<!-- {name} -->\n).*?(<!-- end -->)"
        text, count = re.subn(
            pattern, lambda found, t=table: f"{found[1]}{t}\n{found[2]}", text, flags=re.S
        )
        if count != 1:
            raise ValueError(f"<!-- {name} --> stands {count} times in the text: expected once")
    return text


def main() -> None:
    attitude = pd.concat([read("rivals.csv"), read("directed.csv")])
    tables = {"bar": markdown(bar(attitude))}
    tables |= {f"against {n}": markdown(against(attitude, n)) for n in BUDGETS}
    tables["ablation"] = markdown(ablation(read("ablation.csv")))
    tables["restarts"] = markdown(ablation(read("restarts.csv")))
    tables["elsewhere"] = markdown(elsewhere(read("elsewhere.csv")))
    path = FOLDER / "README.md"
    path.write_text(fill(path.read_text(encoding="utf-8"), tables), encoding="utf-8")
    print("\n\n".join(f"{name}\n{table}" for name, table in tables.items()))


if __name__ == "__main__":
    main()
