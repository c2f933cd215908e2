"""The figure of a front."""

from html import unescape

import numpy as np
import pandas as pd
import pytest

from mgeo.figures.front import draw_front, format_hover_texts, needs_log_axis

X = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.5]])
VARIABLES = ("a [m]", "b")
EVIL = "<a href='https://x'>%{x} & y</a>"


def front(n_obj):
    return np.array([[1.0, 9.0, 0.5], [2.0, 5.0, 0.4], [3.0, 1.0, 0.7]])[:, :n_obj]


def test_two_objectives_are_points_and_the_boundary_of_the_dominated_region():
    F = front(2)[::-1]
    figure = draw_front(X, F, VARIABLES, ("cost", "risk [1/y]"), "title")
    boundary, points = figure.data
    assert (list(points.x), list(points.y)) == (F[:, 0].tolist(), F[:, 1].tolist())
    assert list(boundary.x) == [1.0, 2.0, 3.0]
    assert boundary.line.shape == "hv"
    assert figure.layout.xaxis.title.text == "cost"
    assert figure.layout.yaxis.title.text == "risk [1/y]"


def test_three_objectives_are_points_in_space():
    (points,) = draw_front(X, front(3), VARIABLES, ("p", "q", "r")).data
    assert points.type == "scatter3d"
    assert np.array_equal(np.column_stack([points.x, points.y, points.z]), front(3))


def test_one_objective_is_drawn_over_the_number_of_the_solution():
    (points,) = draw_front(X[:1], front(1)[:1], VARIABLES, ("cost",)).data
    assert (list(points.x), list(points.y)) == ([0], [1.0])


def test_the_hover_text_describes_the_solution():
    texts = format_hover_texts(X, front(2), VARIABLES, ("cost", "risk"))
    assert texts[2] == "solution 2<br><b>cost: 3</b><br><b>risk: 1</b><br>a [m]: 5<br>b: 6.5"
    described = pd.DataFrame({"cost": [3.0], "accuracy [deg]": [0.123456], "plan": ["up"]})
    (text,) = format_hover_texts(X[:1], front(2)[2:], VARIABLES, ("cost", "risk"), described)
    assert text.endswith("<br>accuracy [deg]: 0.12346<br>plan: up")


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (np.geomspace(1.0, 21.0, 50), True),
        (np.geomspace(1.0, 19.0, 50), False),
        (np.linspace(1e-3, 1.0, 50), False),  # a factor of 1000, but evenly spread as it is
        (np.append(np.linspace(1.0, 2.0, 49), 1e-9), False),  # one value near zero
        (np.append(np.geomspace(1.0, 1e6, 49), 0.0), False),  # has no logarithm
    ],
)
def test_an_axis_is_logarithmic_where_that_spreads_the_values(values, expected):
    assert needs_log_axis(values) is expected


@pytest.mark.parametrize("n_obj", [1, 2, 3])
def test_an_empty_front_can_be_drawn(n_obj):
    objectives = ("p", "q", "r")[:n_obj]
    figure = draw_front(np.empty((0, 2)), np.empty((0, n_obj)), VARIABLES, objectives)
    assert len(figure.data[-1].x) == 0


def test_four_objectives_are_refused():
    with pytest.raises(ValueError, match="4 objectives"):
        draw_front(X, np.ones((3, 4)), VARIABLES, ("p", "q", "r", "s"))


@pytest.mark.parametrize("n_obj", [1, 2, 3])
def test_names_are_neither_markup_nor_templates(n_obj):
    names = tuple(f"{EVIL} {i}" for i in range(n_obj))
    described = pd.DataFrame([[EVIL]] * 3, columns=[f"{EVIL} more"])
    figure = draw_front(X, front(n_obj), (EVIL, "b"), names, EVIL, described).to_json()
    assert "<a " not in figure
    assert "\\u003ca" not in figure
    hover = format_hover_texts(X, front(n_obj), (EVIL, "b"), names)[0]
    assert unescape(hover).count(EVIL) == n_obj + 1
