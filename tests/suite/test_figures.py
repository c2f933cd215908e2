"""Tables and figures of suites."""

import numpy as np
import pytest
from mgeo_attitude import evaluate


def test_suite_is_described_as_text(problem):
    assert (
        problem.suites.describe_suite(np.array([0, 1, 0, 0, 0])) == "poor gyro, better magnetometer"
    )
    assert problem.suites.describe_suite(np.array([1, 0, 1, 2, 2])) == (
        "good gyro, mag magnetometer, tracker star tracker, 2 fine Sun sensors (+x, -z)"
    )
    assert problem.suites.describe_suite(np.array([1, 0, 0, 0, 1])).endswith(
        "1 coarse Sun sensor (-z)"
    )


@pytest.mark.slow
def test_table_has_one_row_per_design(problem, points):
    table, F = problem.view(points).describe(), problem.evaluate(points)
    assert np.array_equal(table["price [kEUR]"], F[:, 0])
    assert np.array_equal(table["attitude 1-sigma [deg]"], F[:, 3])
    assert np.array_equal(table["t_end [s]"], F[:, 4])
    options = [problem.suites.get_option_names(row) for row in points[:, :5].astype(int)]
    assert table["gyro"].tolist() == [each["gyro"] for each in options]
    assert f"{points[0, 5]:+.3f}" in table.filter(like="maneuver 1").iloc[0, 0]


def test_points_of_the_front_have_their_row_numbers(problem, points):
    figure = problem.view(points).figures()["front"]
    F = problem.evaluate(points)
    rows = np.concatenate([trace.customdata for trace in figure.data])
    assert sorted(rows) == list(range(len(points)))
    for trace in figure.data:
        assert np.array_equal(trace.x, F[trace.customdata, 0])
        assert np.array_equal(trace.y, F[trace.customdata, 3])
        has_tracker = points[trace.customdata, 2] == 1
        assert has_tracker.all() == (trace.name != "no star tracker")


def test_heatmap_has_the_selected_options(problem, points):
    (heatmap,) = problem.view(points).figures()["sensors"].data
    order = np.argsort(problem.evaluate(points)[:, 0], kind="stable")
    for row, name in enumerate(heatmap.y):
        place = next(place for place in problem.suites.places if place.name == name)
        column = problem.suites.places.index(place)
        expected = [place.options[int(points[i, column])] for i in order]
        assert list(heatmap.text[row]) == expected


def test_solution_figures_show_the_filter_results_of_the_design(problem, points):
    solution_figures = problem.view(points[:3]).solution_figures()
    for row, figures in zip(points, solution_figures, strict=False):
        choice = row[:5].astype(int)
        model = problem.suites.get_suite_model(choice)
        result = evaluate(model, row[None, 5:], history=True)
        (line,) = figures["attitude"].data
        end = round(result.t_end[0] / model.step)
        sigma = np.degrees(np.sqrt(result.variances[0, end, :3].max()))
        assert line.x[-1] == result.t_end[0]
        assert line.y[-1] == pytest.approx(sigma, rel=1e-9)
        assert figures["rates"].data[0].y[0] == pytest.approx(row[5])
