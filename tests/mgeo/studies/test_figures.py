import json

import numpy as np
import pandas as pd
import pytest
from pymoo.problems.many import DTLZ2

from mgeo.studies.comparison import Comparison
from mgeo.studies.figures.fronts import (
    attained_shares,
    attainment_figure,
    difference_figure,
    each_figure,
    fronts_figure,
)
from mgeo.studies.figures.indicators import (
    alike,
    anytime_figure,
    ranks_figure,
    targets_figure,
)
from mgeo.studies.statistics import friedman

from .samples import FRONTS, VALUES, comparison, record


def lines(figure):
    return {trace.name: trace for trace in figure.data if trace.name}


def test_the_curve_is_the_mean_and_lies_in_its_band():
    figure = anytime_figure(comparison())
    for (name, line), band in zip(lines(figure).items(), figure.data[::2], strict=True):
        assert line.x.tolist() == [50, 100]
        assert line.y[1] == pytest.approx(np.mean(VALUES[name]))
        high, low = band.y[1], band.y[2]
        assert min(VALUES[name]) <= low < line.y[1] < high <= max(VALUES[name])
        assert f"<b>{name}</b>" in line.hovertemplate
    assert figure.layout.yaxis.type == "linear"
    assert anytime_figure(comparison(), "igd_plus").layout.yaxis.type == "log"


def test_a_curve_begins_where_all_runs_have_a_value():
    made = comparison()
    made.table.loc[0, "igd_plus"] = np.inf
    found = lines(anytime_figure(made, "igd_plus"))
    assert [trace.x.tolist() for trace in found.values()] == [[100], [50, 100], [50, 100]]


def test_fronts_are_those_of_the_median_runs():
    figure = fronts_figure(comparison())
    assert [trace.name for trace in figure.data] == ["A_1, seed 2", "B, seed 2", "C, seed 1"]
    assert np.column_stack([figure.data[1].x, figure.data[1].y]).tolist() == FRONTS["B"][1]


def test_attainment_surfaces():
    figure = attainment_figure(comparison())
    half, best, every = figure.data[:3]
    # all three runs of A_1 have (1, 2), and one of them (2, 1) too
    assert list(zip(best.x, best.y, strict=True)) == [(1, 2), (2, 1)]
    assert list(zip(half.x, half.y, strict=True)) == [(1, 2)]
    assert list(zip(every.x, every.y, strict=True)) == [(1, 2)]
    of_b = figure.data[3]
    assert list(zip(of_b.x, of_b.y, strict=True)) == [(2, 3)]


def differences(figure):
    """Difference in percent at the lower left corner of each cell with a difference."""
    (heat,) = figure.data
    x, y = heat.x[:-1], heat.y[:-1]
    return {(x[j], y[i]): heat.z[i][j] for i, j in np.argwhere(heat.z)}


def test_the_difference_is_counted_in_runs():
    # two of three runs of A_1 attain (1, 2) to (2, 3) where those of B do not; one of them (2, 1)
    expected = {(1, 2): 67, (1, 3): 67, (2, 1): 33, (2, 2): 67}
    assert differences(difference_figure(comparison(), "A_1", "B")) == expected
    swapped = difference_figure(comparison(), "B", "A_1")
    assert differences(swapped) == {point: -share for point, share in expected.items()}
    assert differences(difference_figure(comparison(), "A_1", "C")) == {}


def test_attained_shares_are_those_of_a_plain_loop():
    rng = np.random.default_rng(2)
    fronts = [rng.random((n, 2)) for n in (1, 5, 0, 7)]
    x, y = rng.random(6), rng.random(4)
    expected = [[np.mean([any(((a, b) >= F).all(axis=1)) for F in fronts]) for a in x] for b in y]
    assert np.array_equal(attained_shares(fronts, x, y), expected)


def test_runs_without_a_front_count_in_what_is_attained():
    """One run of three has a front: it is not what half of them or all of them attain."""
    made = comparison()
    nothing = record(np.empty((0, 2)))
    made.records.update({("B", 1): nothing, ("B", 2): nothing})
    half, best, every = attainment_figure(made).data[3:6]
    assert (len(half.x), best.x.tolist(), len(every.x)) == (0, [1.0], 0)
    # all runs of A_1 attain (1, 2), and one of three of B
    assert differences(difference_figure(made, "A_1", "B"))[1, 2] == 67
    made.records[("B", 3)] = nothing
    assert differences(difference_figure(made, "B", "A_1"))[1, 2] == -100
    assert [t.text for t in each_figure(made).layout.annotations[:2]] == ["A_1", "C"]


def test_ranks_are_drawn_where_they_are():
    figure = ranks_figure(
        friedman(np.transpose(list(VALUES.values())), list(VALUES)), tuple(VALUES)
    )
    bar, *markers = figure.data
    assert bar.x[0] == 1.5
    assert bar.x[-1] == pytest.approx(8 / 3)
    assert "A_1, C, B" in bar.text
    assert [m.x[1] for m in markers] == pytest.approx([1.5, 5.5 / 3, 8 / 3])


@pytest.mark.parametrize(
    ("ranks", "groups"),
    [
        ([1.0, 2.0, 3.0], []),
        ([1.0, 1.5, 1.9, 3.0], [(0, 2)]),
        ([1.0, 1.5, 2.2, 2.4], [(0, 1), (1, 3)]),
        ([1.0, 1.1, 1.2, 1.3], [(0, 3)]),
    ],
)
def test_groups_are_the_largest_within_the_difference(ranks, groups):
    assert alike(ranks, 1.0) == groups


def test_three_objectives_are_drawn_in_space_and_more_are_refused():
    made = comparison()
    three = {
        key: type(r)(**{**vars(r), "F": np.c_[r.F, r.F[:, 0]]}) for key, r in made.records.items()
    }
    spatial = Comparison(**{**vars(made), "problem": DTLZ2(n_obj=3), "records": three})
    figure = fronts_figure(spatial)
    assert {trace.type for trace in figure.data} == {"scatter3d"}
    assert "attainment" not in spatial.figures()
    for draw in (attainment_figure, lambda c: difference_figure(c, "A_1", "B")):
        with pytest.raises(ValueError, match="3 objectives"):
            draw(spatial)
    with pytest.raises(ValueError, match="4 objectives: expected 2 or 3"):
        fronts_figure(Comparison(**{**vars(made), "problem": DTLZ2(n_obj=4)}))


def test_labels_are_neither_markup_nor_templates():
    """Of algorithms and objectives, in every figure of a study."""
    evil = {name: f"<a href='https://x'>%{{x}}</a> {name}" for name in VALUES}
    made = comparison()
    made.problem.obj_names = ("<a href='https://x'>f</a>", "g")
    renamed = Comparison(
        made.problem,
        tuple(evil.values()),
        made.n_eval,
        made.table.replace({"algorithm": evil}),
        made.runs,
        {(evil[name], seed): each for (name, seed), each in made.records.items()},
        made.space,
    )
    ranked = friedman(np.array([[1.0, 2.0, 3.0], [1.0, 3.0, 2.0]]), list(evil.values()))
    reached = pd.DataFrame({"algorithm": evil["B"], "evaluations": [1.0, 2.0], "share": [0.1, 0.2]})
    figures = {
        **renamed.figures(),
        "ranks": ranks_figure(ranked, tuple(evil.values())),
        "targets": targets_figure(reached, 1),
    }
    assert len(figures) == 8
    for name, figure in figures.items():
        tree = figure.to_plotly_json()
        for trace in tree["data"]:
            trace.pop("legendgroup", None)  # is not shown
        texts = json.dumps(tree, default=lambda value: np.asarray(value).tolist())
        assert "&lt;a href" in texts, name
        assert "<a href" not in texts, name
