"""What each kind of move contributes along a run of `MGEODirected`.

    .venv/bin/python docs/studies/moves.py

from the folder above docs writes data/moves.csv, which directed.md draws: of 14 of COCO's functions
in 10 variables (an instance for tuning) and of the paper's satellite, by kind and by stretch of the
run, the shares of the candidates made, of those that entered the front, and of the gain of
hypervolume. Needs the extra: pip install 'mgeo[coco]'.
"""

from bisect import bisect_left
from pathlib import Path

import numpy as np
import pandas as pd
from plotly.subplots import make_subplots

from mgeo import MGEODirected, ParetoArchive
from mgeo.plugins.problems import load_problem

DATA = Path(__file__).parent / "data" / "moves.csv"
KINDS = ("normal step", "difference", "momentum", "recombination")
EDGES = (0, 10, 20, 50, 100, 200, 500, 1_000)  # evaluations per variable
FUNCTIONS = (1, 3, 5, 8, 9, 16, 21, 28, 35, 42, 46, 50, 53, 55)  # as in ablation.toml
SEEDS = range(1, 6)  # of the satellite


class Watched(MGEODirected):
    """The same run, bit by bit; `seen` has kinds, objectives and violations of all candidates."""

    def __init__(self, **options):
        super().__init__(**options)
        self.seen = []

    def generate_candidates(self):
        n = min(len(self.variables.xl), self.max_candidates)
        self._kinds = np.zeros((self.n_walkers, n), int)  # as long as there is no front
        X = super().generate_candidates()
        self._kinds[self.is_recombined] = 3
        return X

    def _apply_momentum(self, steps, spread, donor, nearest_points):
        learned, before = (spread == 0.0).all(axis=-1), steps.copy()
        super()._apply_momentum(steps, spread, donor, nearest_points)
        made = (steps != before).any(axis=-1)
        self._kinds = np.where(made, 2, np.where(learned, 1, 0))

    def accept(self, F, violation):
        self.seen.append((self._kinds.ravel(), F.copy(), violation.copy()))
        return super().accept(F, violation)


def gains(problem, seed):
    """A row a feasible candidate: stretch, kind, whether it entered the front, what it added.

    That is hypervolume, scaled by the front at the end of the stretch; its reference point is 1.1.
    Candidates of a generation count in the order of the walkers, which says nothing of their kinds.
    """
    algorithm = Watched()
    algorithm.setup(problem, seed=seed, termination=("n_eval", EDGES[-1] * problem.n_var))
    algorithm.run()
    kinds, F, violation = (np.concatenate(each) for each in zip(*algorithm.seen, strict=True))
    last = np.array(EDGES[1:]) * problem.n_var
    of_stretch = np.searchsorted(last, np.arange(len(F)), side="right")
    known, steps = ParetoArchive(2), Staircase()
    rows = []
    for k, until in enumerate(EDGES[1:]):
        numbers = np.flatnonzero(of_stretch == k)
        known.add(F[numbers], numbers.astype(object), violation[numbers])
        ideal, nadir = known.ideal_and_nadir
        width = np.where(nadir > ideal, nadir - ideal, 1.0)
        for i in numbers[(violation[numbers] == 0) & np.isfinite(F[numbers]).all(axis=1)]:
            gain = steps.add(*F[i].tolist(), *(ideal + 1.1 * width).tolist())
            rows.append((until, kinds[i], gain is not None, (gain or 0.0) / width.prod()))
    return pd.DataFrame(rows, columns=["until", "kind", "entered", "gain"])


class Staircase:
    """A front of two objectives that tells by how much each new point raises its hypervolume."""

    def __init__(self):
        self.f, self.g = [], []  # ascending, and descending

    def add(self, x, y, x_end, y_end):
        """The area that is dominated by the new point alone, up to the reference point, or None."""
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
    """By stretch of the run and kind: shares of candidates, of those that entered, of the gain."""
    found = gains(problem, seed).assign(candidates=1.0)
    sums = found.groupby(["until", "kind"])[["candidates", "entered", "gain"]].sum()
    return sums.div(sums.groupby("until").transform("sum").replace(0.0, np.nan))


def moves_figure():
    """Shares of the gain of hypervolume, and of the candidates, by kind along a run."""
    table = pd.read_csv(DATA)
    titles = {"COCO": "14 functions of COCO, 10 variables", "satellite": "the paper's satellite"}
    figure = make_subplots(cols=2, subplot_titles=list(titles.values()), shared_yaxes=True)
    for column, problems in enumerate(titles, 1):
        for kind, color in zip(KINDS, ("#009e73", "#0072b2", "#d55e00", "#cc79a7"), strict=True):
            rows = table[(table["problems"] == problems) & (table["kind"] == kind)]
            for value, dash in (("gain", "solid"), ("candidates", "dot")):
                figure.add_scatter(
                    x=rows["until"],
                    y=rows[value],
                    line={"color": color, "dash": dash},
                    name=f"{kind}, {value}",
                    showlegend=column == 1,
                    row=1,
                    col=column,
                )
        figure.update_xaxes(type="log", title="evaluations per variable", row=1, col=column)
    figure.update_yaxes(title="share", range=[0, 1], row=1, col=1)
    return figure.update_layout(
        template="plotly_white", height=420, margin={"l": 60, "r": 20, "t": 50, "b": 50}
    )


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
