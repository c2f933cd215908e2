from html import unescape

import numpy as np
import pandas as pd
import pytest

from mgeo.figures.front import draw_front, format_hover_texts, needs_log_axis

X = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.5]])
VARIABLES = ("a [m]", "b")
MALICIOUS_NAME = "<a href='https://x'>%{x} & y</a>"


def build_front(n_obj):
    return np.array([[1.0, 9.0, 0.5], [2.0, 5.0, 0.4], [3.0, 1.0, 0.7]])[:, :n_obj]


def test_two_objectives_are_drawn_with_boundary_of_dominated_region():
    F = build_front(2)[::-1]
    figure = draw_front(X, F, VARIABLES, ("cost", "risk [1/y]"), "title")
    boundary, points = figure.data
    assert (list(points.x), list(points.y)) == (F[:, 0].tolist(), F[:, 1].tolist())
    assert list(boundary.x) == [1.0, 2.0, 3.0]
    assert boundary.line.shape == "hv"
    assert figure.layout.xaxis.title.text == "cost"
    assert figure.layout.yaxis.title.text == "risk [1/y]"


def test_three_objectives_are_drawn_in_3d():
    (points,) = draw_front(X, build_front(3), VARIABLES, ("p", "q", "r")).data
    assert points.type == "scatter3d"
    assert np.array_equal(np.column_stack([points.x, points.y, points.z]), build_front(3))


def test_one_objective_is_drawn_over_solution_number():
    (points,) = draw_front(X[:1], build_front(1)[:1], VARIABLES, ("cost",)).data
    assert (list(points.x), list(points.y)) == ([0], [1.0])


def test_hover_text_describes_solution():
    texts = format_hover_texts(X, build_front(2), VARIABLES, ("cost", "risk"))
    assert texts[2] == "solution 2<br><b>cost: 3</b><br><b>risk: 1</b><br>a [m]: 5<br>b: 6.5"
    described = pd.DataFrame({"cost": [3.0], "accuracy [deg]": [0.123456], "plan": ["up"]})
    (text,) = format_hover_texts(X[:1], build_front(2)[2:], VARIABLES, ("cost", "risk"), described)
    assert text.endswith("<br>accuracy [deg]: 0.12346<br>plan: up")


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (np.geomspace(1.0, 21.0, 50), True),
        (np.geomspace(1.0, 19.0, 50), False),
        (np.linspace(1e-3, 1.0, 50), False),  # Evenly spaced in spite of a factor of 1000.
        (np.append(np.linspace(1.0, 2.0, 49), 1e-9), False),  # Only one value is near zero.
        (np.append(np.geomspace(1.0, 1e6, 49), 0.0), False),  # Zero has no logarithm.
    ],
)
def test_axis_is_logarithmic_for_skewed_values(values, expected):
    assert needs_log_axis(values) is expected


@pytest.mark.parametrize("n_obj", [1, 2, 3])
def test_empty_front_can_be_drawn(n_obj):
    objectives = ("p", "q", "r")[:n_obj]
    figure = draw_front(np.empty((0, 2)), np.empty((0, n_obj)), VARIABLES, objectives)
    assert len(figure.data[-1].x) == 0


def test_four_objectives_are_rejected():
    with pytest.raises(ValueError, match="4 objectives"):
        draw_front(X, np.ones((3, 4)), VARIABLES, ("p", "q", "r", "s"))


@pytest.mark.parametrize("n_obj", [1, 2, 3])
def test_names_are_escaped(n_obj):
    names = tuple(f"{MALICIOUS_NAME} {i}" for i in range(n_obj))
    described = pd.DataFrame([[MALICIOUS_NAME]] * 3, columns=[f"{MALICIOUS_NAME} more"])
    figure = draw_front(
        X, build_front(n_obj), (MALICIOUS_NAME, "b"), names, MALICIOUS_NAME, described
    ).to_json()
    assert "<a " not in figure
    assert "\\u003ca" not in figure
    hover = format_hover_texts(X, build_front(n_obj), (MALICIOUS_NAME, "b"), names)[0]
    assert unescape(hover).count(MALICIOUS_NAME) == n_obj + 1
