"""The look that all figures share."""

import numpy as np
import plotly.graph_objects as go
import pytest

from mgeo.figures.style import COLORS, SYMBOLS, finished, log_axis


@pytest.mark.parametrize(("values", "dtick"), [([2e-3, 1.9], "D2"), ([[1.0, 5.0], [1e4, 2.0]], 1)])
def test_wide_axes_have_labels_at_powers_of_ten_only(values, dtick):
    axis = log_axis(np.array(values))
    assert (axis["type"], axis["dtick"]) == ("log", dtick)


@pytest.mark.parametrize("values", [[1.5e-6, 1.9e-6], [2e-4, 2e-4], [2.1, 9.9]])
def test_near_values_have_labels_though_none_is_at_1_2_or_5(values):
    assert "dtick" not in log_axis(values)  # which leaves it to plotly


def test_no_figure_depends_on_color_alone():
    assert len(set(COLORS)) == len(set(SYMBOLS)) == len(COLORS)


def test_titles_stand_above_subtitles():
    figure = finished(go.Figure(go.Scatter(y=[1.0])), "Title", "what it shows")
    assert figure.layout.title.text.startswith("Title<br>")
    assert "what it shows" in figure.layout.title.text
    assert figure.layout.xaxis.showline
