"""Tables of single studies and scripts, each for one page."""

import pandas as pd
from IPython.display import Markdown
from show import table
from stored_studies import CONTROL, HERE, format_name, load_values

from mgeo.studies.aggregation import compute_average_ranks

#: Changes of the ablation, by label in the study file.
_CHANGES = {
    "no selection pressure": "no selection pressure, τ = 0",
    "always the best": "the best candidate is always accepted, τ = 50",
    "no extreme weights": "no walkers with extreme weights",
    "no differences": "no difference steps",
    "one share of differences": "equal share of difference steps for all walkers, 0.4",
    "no coupling": "normal steps and differences in one variable only",
    "one coupling": "equal coupling of normal steps and differences, 0.2",
    "one width of steps": "one standard deviation of normal steps, 0.05",
    "no return": "no return to the best point",
    "no migration": "no return to the archive",
    "one migration": "equal return to the archive for all walkers, 0.1",
    "one restart": "equal patience for all walkers, 15 generations",
    "all variables tried": "up to 20 candidates per walker",
    "one variable tried": "one candidate per walker",
    "no attraction": "no differences towards the archive",
    "no momentum": "no steps with momentum",
    "nearest targets": "momentum to the nearest archived point only",
    "any targets": "momentum to random archived points only",
    "any progress counts": "any decrease of the distance is progress",
    "one measure of progress": "constant threshold of progress, 0.001",
    "one share of recombination": "constant share of recombination",
}


def ablation() -> Markdown:
    """Return a table of the shares of problems on which the changed algorithms are behind."""
    ranks = compute_average_ranks(load_values("ablation"), "default")
    ranks = ranks[(ranks["variables"] == 0) & ranks["evaluations"].isin((100, 500))]
    shares = ranks.pivot(index="algorithm", columns="evaluations", values="share_control_better")
    shares = shares.drop("default").rename(index=_CHANGES).sort_values(500, ascending=False)
    texts = shares.map("{:.0%}".format).rename(columns="behind after {:.0f}".format)
    return table(texts.rename_axis("change"))


def equalities() -> Markdown:
    """Return a table of the median and range of the results of docs/studies/equalities.py."""
    runs = pd.read_csv(HERE / "data" / "equalities.csv")
    groups = runs.groupby(["problem", "algorithm"], sort=False)["share"]
    texts = groups.agg(lambda x: f"{x.median():.2f} ({x.min():.2f} to {x.max():.2f})")
    return table(texts.unstack()[list(dict.fromkeys(runs["algorithm"]))])


def polished() -> Markdown:
    """Return a table of gain and cost of the local refinement, by docs/studies/polished.py."""
    rows = pd.read_csv(HERE / "data" / "polished.csv").fillna(0)
    suffix = rows["stage"].map({"search": "", "polish": ", refined"})
    rows["front"] = rows["algorithm"].map(format_name) + suffix
    columns = {
        "hypervolume_1": ("hypervolume, to 1200", "{:.4f}"),
        "hypervolume_2": ("from 1200 to 6000", "{:.4f}"),
        "hypervolume_3": ("from 6000", "{:.4f}"),
        "whole": ("plans evaluated", "{:,.0f}"),
        "at_one_time": ("at one time", "{:,.0f}"),
        "cpu_s": ("CPU [s]", "{:.1f}"),
    }
    means = rows.groupby("front", sort=False)[list(columns)].mean()
    return table(pd.DataFrame({title: means[c].map(f.format) for c, (title, f) in columns.items()}))


def under_noise() -> dict[float, pd.DataFrame]:
    """Return the average ranks over functions for each noise level of docs/studies/noise.py."""
    rows = pd.read_csv(HERE / "data" / "noise.csv")
    ranks = {}
    for noise, now in rows.groupby("noise"):
        values = now.pivot_table("hypervolume", "problem", "algorithm").rename(columns=format_name)
        values = values.reset_index()
        # All problems have the same size and budget, and each function occurs once.
        values = values.assign(function=values["problem"], variables=0, evaluations=0)
        ranks[noise] = compute_average_ranks(values, CONTROL)
    return ranks
