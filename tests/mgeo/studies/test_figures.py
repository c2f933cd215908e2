import json

import numpy as np
import pandas as pd
import pytest
from pymoo.problems.many import DTLZ2

from mgeo.studies.comparison import Comparison
from mgeo.studies.figures.fronts import (
    compute_attainment,
    draw_attainment_difference,
    draw_attainment_surfaces,
    draw_front_panels,
    draw_median_fronts,
)
from mgeo.studies.figures.indicators import (
    draw_anytime_curves,
    draw_critical_difference_diagram,
    draw_runtime_distribution,
    find_equivalent_groups,
)
from mgeo.studies.statistics import friedman_test

from .samples import FRONTS, VALUES, build_comparison, build_run


def traces_by_name(figure):
    return {trace.name: trace for trace in figure.data if trace.name}


def test_curve_is_mean_of_runs_inside_its_band():
    figure = draw_anytime_curves(build_comparison())
    for (name, line), band in zip(traces_by_name(figure).items(), figure.data[::2], strict=True):
        assert line.x.tolist() == [50, 100]
        assert line.y[1] == pytest.approx(np.mean(VALUES[name]))
        high, low = band.y[1], band.y[2]
        assert min(VALUES[name]) <= low < line.y[1] < high <= max(VALUES[name])
        assert f"<b>{name}</b>" in line.hovertemplate
        assert band.mode == "none"  # The band has no markers.
    assert figure.layout.yaxis.type == "linear"
    assert draw_anytime_curves(build_comparison(), "igd_plus").layout.yaxis.type == "log"


def test_curve_begins_where_all_runs_have_finite_values():
    result = build_comparison()
    result.table.loc[0, "igd_plus"] = np.inf
    curves = traces_by_name(draw_anytime_curves(result, "igd_plus"))
    assert [trace.x.tolist() for trace in curves.values()] == [[100], [50, 100], [50, 100]]


def test_drawn_fronts_are_those_of_median_runs():
    figure = draw_median_fronts(build_comparison())
    assert [trace.name for trace in figure.data] == ["A_1, seed 2", "B, seed 2", "C, seed 1"]
    assert np.column_stack([figure.data[1].x, figure.data[1].y]).tolist() == FRONTS["B"][1]


def test_attainment_surfaces_of_best_median_and_worst():
    figure = draw_attainment_surfaces(build_comparison())
    half, best, every = figure.data[:3]
    # All three runs of A_1 have (1, 2), and one of them also has (2, 1).
    assert list(zip(best.x, best.y, strict=True)) == [(1, 2), (2, 1)]
    assert list(zip(half.x, half.y, strict=True)) == [(1, 2)]
    assert list(zip(every.x, every.y, strict=True)) == [(1, 2)]
    best_of_b = figure.data[3]
    assert list(zip(best_of_b.x, best_of_b.y, strict=True)) == [(2, 3)]


def read_differences(figure):
    """Return the nonzero differences in percent by the lower left corner of their cells."""
    (heat,) = figure.data
    x, y = heat.x[:-1], heat.y[:-1]
    return {(x[j], y[i]): heat.z[i][j] for i, j in np.argwhere(heat.z)}


def test_attainment_difference_is_in_percent_of_runs():
    # Two of three runs of A_1 attain (1, 2) to (2, 3) and those of B do not; one attains (2, 1).
    expected = {(1, 2): 67, (1, 3): 67, (2, 1): 33, (2, 2): 67}
    assert read_differences(draw_attainment_difference(build_comparison(), "A_1", "B")) == expected
    swapped = draw_attainment_difference(build_comparison(), "B", "A_1")
    assert read_differences(swapped) == {point: -share for point, share in expected.items()}
    assert read_differences(draw_attainment_difference(build_comparison(), "A_1", "C")) == {}


def test_attainment_equals_direct_enumeration():
    rng = np.random.default_rng(2)
    fronts = [rng.random((n, 2)) for n in (1, 5, 0, 7)]
    x, y = rng.random(6), rng.random(4)
    expected = [[np.mean([any(((a, b) >= F).all(axis=1)) for F in fronts]) for a in x] for b in y]
    assert np.array_equal(compute_attainment(fronts, x, y), expected)


def test_empty_fronts_count_as_runs_that_attain_nothing():
    result = build_comparison()
    empty = build_run(np.empty((0, 2)))
    result.finished_runs.update({("B", 1): empty, ("B", 2): empty})
    half, best, every = draw_attainment_surfaces(result).data[3:6]
    assert (len(half.x), best.x.tolist(), len(every.x)) == (0, [1.0], 0)
    # All runs of A_1 attain (1, 2), and one of three runs of B.
    assert read_differences(draw_attainment_difference(result, "A_1", "B"))[1, 2] == 67
    result.finished_runs[("B", 3)] = empty
    assert read_differences(draw_attainment_difference(result, "B", "A_1"))[1, 2] == -100
    assert [t.text for t in draw_front_panels(result).layout.annotations[:2]] == ["A_1", "C"]


def test_critical_difference_diagram_shows_ranks_and_groups():
    figure = draw_critical_difference_diagram(
        friedman_test(np.transpose(list(VALUES.values())), list(VALUES)), tuple(VALUES)
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
def test_equivalent_groups_are_maximal(ranks, groups):
    assert find_equivalent_groups(ranks, 1.0) == groups


def test_three_objectives_are_drawn_in_3d_and_four_are_rejected():
    result = build_comparison()
    three = {
        key: type(r)(**{**vars(r), "F": np.c_[r.F, r.F[:, 0]]})
        for key, r in result.finished_runs.items()
    }
    spatial = Comparison(**{**vars(result), "problem": DTLZ2(n_obj=3), "finished_runs": three})
    figure = draw_median_fronts(spatial)
    assert {trace.type for trace in figure.data} == {"scatter3d"}
    assert "attainment" not in spatial.draw_figures()
    for draw in (draw_attainment_surfaces, lambda c: draw_attainment_difference(c, "A_1", "B")):
        with pytest.raises(ValueError, match="3 objectives"):
            draw(spatial)
    with pytest.raises(ValueError, match="4 objectives: expected 2 or 3"):
        draw_median_fronts(Comparison(**{**vars(result), "problem": DTLZ2(n_obj=4)}))


def test_labels_are_escaped_in_all_figures():
    labels = {name: f"<a href='https://x'>%{{x}}</a> {name}" for name in VALUES}
    result = build_comparison()
    result.problem.obj_names = ("<a href='https://x'>f</a>", "g")
    renamed = Comparison(
        result.problem,
        tuple(labels.values()),
        result.n_eval,
        result.table.replace({"algorithm": labels}),
        result.runs,
        {(labels[name], seed): run for (name, seed), run in result.finished_runs.items()},
        result.space,
    )
    friedman = friedman_test(np.array([[1.0, 2.0, 3.0], [1.0, 3.0, 2.0]]), list(labels.values()))
    distribution = pd.DataFrame(
        {"algorithm": labels["B"], "evaluations": [1.0, 2.0], "share": [0.1, 0.2]}
    )
    figures = {
        **renamed.draw_figures(),
        "ranks": draw_critical_difference_diagram(friedman, tuple(labels.values())),
        "targets": draw_runtime_distribution(distribution, 1),
    }
    assert len(figures) == 8
    for name, figure in figures.items():
        tree = figure.to_plotly_json()
        for trace in tree["data"]:
            trace.pop("legendgroup", None)  # The group is not shown.
        texts = json.dumps(tree, default=lambda value: np.asarray(value).tolist())
        assert "&lt;a href" in texts, name
        assert "<a href" not in texts, name
