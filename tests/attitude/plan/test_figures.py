"""Figures of a plan: their numbers are its tables'."""

import numpy as np
import plotly.graph_objects as go
from mgeo_attitude.figures.page import page
from mgeo_attitude.plan.figures import plan_figures


def test_numbers(plan):
    figures = plan_figures(plan)
    assert list(figures) == ["rates", "gains", "correlation"]
    rates = figures["rates"].data[0]
    np.testing.assert_array_equal(rates.x, [0.0, 100.0, plan.t_end])
    np.testing.assert_allclose(rates.y, [0.5, 0.3, 0.3])
    heat = figures["correlation"].data[0]
    np.testing.assert_array_equal(heat.z, plan.correlations())
    assert heat.x[0] == heat.y[0] == "attitude x"
    lines = {line.name: line for line in figures["gains"].data}
    assert list(lines)[-1] == "mag bias"
    table = plan.gains()
    worst = table[[f"mag bias {axis} [nT]" for axis in "xyz"]].max(axis=1)
    np.testing.assert_allclose(lines["mag bias"].customdata, worst)
    np.testing.assert_allclose(lines["mag bias"].y, worst / 2000.0)
    assert len(lines["mag bias"].x) == len(set(lines["mag bias"].x)) == len(table)


def test_a_page_holds_every_figure_and_the_library_once():
    one, two = go.Figure(go.Scatter(y=[1, 2])), go.Figure(go.Scatter(y=[3, 4]))
    html = page([one, two], "<plan>")
    assert html == page([one, two], "<plan>")
    assert "<title>&lt;plan&gt;</title>" in html
    assert html.count('class="plotly-graph-div"') == 2
    assert len(html) < 1.5 * len(page([one], ""))
    assert 'src="http' not in html
