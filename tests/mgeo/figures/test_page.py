from html.parser import HTMLParser

import plotly.graph_objects as go
import pytest

from mgeo.figures.page import page, report_page

LOADING = {"src", "href", "data", "poster", "srcset", "action"}


class Links(HTMLParser):
    """Collects what a browser would load because of a tag."""

    def __init__(self):
        super().__init__()
        self.found, self.titles, self._tag = [], [], ""

    def handle_starttag(self, tag, attrs):
        self._tag = tag
        self.found += [(tag, value) for name, value in attrs if name in LOADING]

    def handle_data(self, data):
        if self._tag == "title":
            self.titles.append(data.strip())


@pytest.fixture(scope="module")
def html():
    return page(go.Figure(go.Scatter(x=[1, 2], y=[3, 4])), "a < b & c")


def test_a_page_loads_nothing_and_has_the_library_inside(html):
    links = Links()
    links.feed(html)
    assert links.found == []
    assert "@import" not in html.split("</style>")[0]
    assert "Plotly.newPlot(" in html
    assert len(html) > 1_000_000


def test_a_page_has_its_title_escaped(html):
    assert "<title>a &lt; b &amp; c</title>" in html


def test_the_title_of_a_figure_is_text_that_breaks_where_it_must():
    title = "Front &amp; back<br><span style='font-size: 17px'>of &lt;b&gt;</span>"
    figure = go.Figure(go.Scatter(x=[1], y=[1])).update_layout(title=title)
    for html in (page(figure, "t"), report_page("t", [figure])):
        assert "<h2>Front &amp; back</h2>" in html
        assert "<p class=note>of &lt;b&gt;</p>" in html
        assert "17px" not in html
        assert 'name="viewport"' in html
    assert figure.layout.title.text == title  # of the figure itself nothing is taken


def test_a_note_is_said_above():
    html = page(go.Figure(), "t", "nothing < kept")
    assert "<p class=told>nothing &lt; kept</p>" in html


def test_the_same_figure_gives_the_same_page(html):
    assert page(go.Figure(go.Scatter(x=[1, 2], y=[3, 4])), "a < b & c") == html
