"""Contribution of each kind of candidate along a run of `MGEODirected`.

    .venv/bin/python docs/studies/moves.py

from the folder above docs writes data/moves.csv, which parts.md plots. For each kind of
candidate and each interval of a run, the table contains the share of all candidates, of the
candidates that entered the front, and of the gain of hypervolume. The problems are 14 functions of
COCO in 10 variables (an instance for tuning) and the paper's satellite. Needs the extra: pip
install 'mgeo[coco]'.
"""

from bisect import bisect_left
from pathlib import Path

import numpy as np
import pandas as pd
from draw import format_for_page
from plotly.subplots import make_subplots

from mgeo import MGEODirected, ParetoArchive
from mgeo.plugins.problems import load_problem

DATA = Path(__file__).parent / "data" / "moves.csv"
KINDS = ("normal step", "difference", "momentum", "recombination")
EDGES = (0, 10, 20, 50, 100, 200, 500, 1_000)  # evaluations per variable
FUNCTIONS = (1, 3, 5, 8, 9, 16, 21, 28, 35, 42, 46, 50, 53, 55)  # as in ablation.toml
SEEDS = range(1, 6)  # of the satellite


class Watched(MGEODirected):
    """MGEODirected that records kind, objectives and violation of all candidates in `seen`.

    The recording does not affect the run.
    """

    def __init__(self, **options):
        super().__init__(**options)
        self.seen = []

    def generate_candidates(self):
        n = min(len(self.variables.xl), self.max_candidates)
        self._kinds = np.zeros((self.n_walkers, n), int)  # Normal steps, before there is a front.
        X = super().generate_candidates()
        self._kinds[self.is_recombined] = 3
        return X

    def _apply_momentum(self, steps, spread, donor, nearest_points):
        is_difference, before = (spread == 0.0).all(axis=-1), steps.copy()
        super()._apply_momentum(steps, spread, donor, nearest_points)
        has_momentum = (steps != before).any(axis=-1)
        self._kinds = np.where(has_momentum, 2, np.where(is_difference, 1, 0))

    def accept(self, F, violation):
        self.seen.append((self._kinds.ravel(), F.copy(), violation.copy()))
        return super().accept(F, violation)


def gains(problem, seed):
    """Return a table of the feasible candidates of a run, with their gains of hypervolume.

    Columns are the end of the interval, the kind, whether the candidate entered the front, and the
    gain. The hypervolume is scaled by the front at the end of the interval, with the reference
    point 1.1. Candidates of a generation are added in the order of the walkers, which does not
    depend on their kinds.
    """
    algorithm = Watched()
    algorithm.setup(problem, seed=seed, termination=("n_eval", EDGES[-1] * problem.n_var))
    algorithm.run()
    kinds, F, violation = (np.concatenate(each) for each in zip(*algorithm.seen, strict=True))
    last = np.array(EDGES[1:]) * problem.n_var
    interval = np.searchsorted(last, np.arange(len(F)), side="right")
    archive, front = ParetoArchive(2), Staircase()
    rows = []
    for k, until in enumerate(EDGES[1:]):
        numbers = np.flatnonzero(interval == k)
        archive.add(F[numbers], numbers.astype(object), violation[numbers])
        ideal, nadir = archive.ideal_and_nadir
        width = np.where(nadir > ideal, nadir - ideal, 1.0)
        for i in numbers[(violation[numbers] == 0) & np.isfinite(F[numbers]).all(axis=1)]:
            gain = front.add(*F[i].tolist(), *(ideal + 1.1 * width).tolist())
            rows.append((until, kinds[i], gain is not None, (gain or 0.0) / width.prod()))
    return pd.DataFrame(rows, columns=["until", "kind", "entered", "gain"])


class Staircase:
    """Front of two objectives that computes the gain of hypervolume by each new point."""

    def __init__(self):
        self.f, self.g = [], []  # Objectives, ascending and descending.

    def add(self, x, y, x_end, y_end):
        """Add the point (x, y) and return its gain of hypervolume, or None for a dominated point.

        The reference point is (x_end, y_end).
        """
        f, g = self.f, self.g
        first = bisect_left(f, x)
        if (first and g[first - 1] <= y) or (first < len(f) and f[first] == x and g[first] <= y):
            return None
        last = first
        while last < len(f) and g[last] >= y:
            last += 1
        ends = [min(end, x_end) for end in (x, *f[first:last], f[last] if last < len(f) else x_end)]
        tops = [min(top, y_end) for top in (g[first - 1] if first else y_end, *g[first:last])]
        f[first:last], g[first:last] = [x], [y]
        spans = zip(ends[:-1], ends[1:], tops, strict=True)
        return sum((right - left) * max(top - y, 0.0) for left, right, top in spans)


def shares(problem, seed):
    """Return the share of each kind in the candidates, entered points and gain, by interval."""
    table = gains(problem, seed).assign(candidates=1.0)
    sums = table.groupby(["until", "kind"])[["candidates", "entered", "gain"]].sum()
    return sums.div(sums.groupby("until").transform("sum").replace(0.0, np.nan))


def moves_figure():
    """Return a figure of the shares in the gain of hypervolume and in the candidates, by kind."""
    table = pd.read_csv(DATA)
    titles = {"COCO": "14 functions of COCO, 10 variables", "satellite": "the paper's satellite"}
    figure = make_subplots(rows=2, subplot_titles=list(titles.values()), vertical_spacing=0.1)
    for row, problems in enumerate(titles, 1):
        for kind, color in zip(KINDS, ("#009e73", "#0072b2", "#d55e00", "#cc79a7"), strict=True):
            rows = table[(table["problems"] == problems) & (table["kind"] == kind)]
            for value, dash in (("gain", "solid"), ("candidates", "dot")):
                figure.add_scatter(
                    x=rows["until"],
                    y=rows[value],
                    line={"color": color, "dash": dash},
                    name=f"{kind}, {value}",
                    showlegend=row == 1,
                    row=row,
                    col=1,
                )
    figure.update_xaxes(type="log", tickvals=EDGES[1:], tickformat=",d")
    figure.update_xaxes(title="evaluations per variable", row=2, col=1)
    figure.update_yaxes(title="share", range=[0, 1], tickformat=".0%")
    return format_for_page(figure, 760).update_layout(margin_t=60)


def main():
    functions = [(f"coco:bbob-biobj/f{f}/d10/i1", 1) for f in FUNCTIONS]
    cases = {"COCO": functions, "satellite": [("attitude", seed) for seed in SEEDS]}
    tables = {
        title: pd.concat([shares(load_problem(name, {}), seed) for name, seed in runs])
        .groupby(["until", "kind"])
        .mean()
        for title, runs in cases.items()
    }
    table = pd.concat(tables, names=["problems"]).reset_index()
    table["kind"] = np.array(KINDS)[table["kind"]]
    table.to_csv(DATA, index=False, lineterminator="\n", float_format="%.3f")
    print(table.to_string(index=False))


if __name__ == "__main__":
    main()
