import plotly.graph_objects as go

from mgeo.figures.page import render_figure_page, render_report_page

from ..report.conftest import Page


def test_page_includes_library_and_loads_nothing():
    html = render_figure_page(go.Figure(go.Scatter(x=[1, 2], y=[3, 4])), "a < b & c", "a note < d")
    assert Page(html).loading == []
    assert "Plotly.newPlot(" in html
    assert len(html) > 1_000_000
    assert "<title>a &lt; b &amp; c</title>" in html
    assert "a note &lt; d" in html
    assert (
        render_figure_page(go.Figure(go.Scatter(x=[1, 2], y=[3, 4])), "a < b & c", "a note < d")
        == html
    )


def test_title_of_figure_becomes_text_of_page():
    title = "Front &amp; back<br><span style='font-size: 17px'>of &lt;b&gt;</span>"
    figure = go.Figure(go.Scatter(x=[1], y=[1])).update_layout(title=title)
    for html in (render_figure_page(figure, "t"), render_report_page("t", [figure])):
        assert "<h2>Front &amp; back</h2>" in html
        assert "<p class=note>of &lt;b&gt;</p>" in html
        assert "17px" not in html
    assert figure.layout.title.text == title  # The figure itself is unchanged.
