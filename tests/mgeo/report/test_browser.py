"""Report of a run in headless Chromium: selection of solutions, table, and layout."""

import numpy as np
import plotly.graph_objects as go
import pytest
from selenium.webdriver import ActionChains
from selenium.webdriver.common.keys import Keys

from mgeo.report import build_report_html
from mgeo.store.run_folder import read_run

from ...browser import opened

pytestmark = pytest.mark.slow

BAR = "document.querySelector('#figures .js-plotly-plot').data[0].y[0]"
TABLE = (
    "[...document.querySelectorAll('#table tbody tr')].map((row) => "
    "[...row.cells].map((cell) => Number(cell.textContent)))"
)


@pytest.fixture
def folder(solved, monkeypatch):
    """Run folder of a problem that draws a bar of the diameter for each solution."""
    from stand_in import CantileverView

    def draw_bars(self):
        return [{"bar": go.Figure(go.Bar(x=["diameter"], y=[x[0]]))} for x in self.X]

    monkeypatch.setattr(CantileverView, "solution_figures", draw_bars, raising=False)
    # Without figures of the problem, mgeo draws the front.
    monkeypatch.delattr(CantileverView, "figures")
    return solved("--record")


@pytest.fixture
def path(folder, tmp_path):
    file = tmp_path / "page.html"
    file.write_text(build_report_html(folder), encoding="utf-8")
    return file


def test_click_on_the_front_shows_the_solution(folder, path):
    X = read_run(folder).outcome.X
    with opened(f"{path}#solution=0") as page:
        assert page.evaluate(BAR) == pytest.approx(X[0, 0])
        points = page.driver.find_elements("css selector", "#front .scatterlayer .point")
        ActionChains(page.driver).move_to_element(points[5]).pause(0.3).click().perform()
        page.until("document.body.dataset.shown === '5'")
        assert page.evaluate(BAR) == pytest.approx(X[5, 0])
        assert page.evaluate("location.hash") == "#solution=5"
        assert page.errors() == []


def test_page_is_accessible(path):
    with opened(path) as page:
        levels = page.evaluate(
            "[...document.querySelectorAll('h1, h2, h3, h4')].map((h) => Number(h.tagName[1]))"
        )
        assert levels[0] == 1
        assert max(np.diff(levels)) <= 1  # No level of headings is skipped.
        assert page.evaluate("document.querySelectorAll('th:not([scope])').length") == 0
        labels = page.evaluate(
            "[...document.querySelectorAll('.js-plotly-plot')].map((f) => f.ariaLabel)"
        )
        assert len(labels) == 3
        assert "mass [kg]" in labels[0]
        assert "bar" in labels[1]
        assert "hypervolume" in labels[2]
        page.run("choose(2)")
        live = "document.querySelector('[aria-live]').textContent"
        page.until(f"{live}.startsWith('2')")


def test_print_layout_opens_all_details(path):
    closed = "document.querySelectorAll('details:not([open])').length"
    with opened(path) as page:
        assert page.evaluate(closed) > 0
        page.print()
        assert page.evaluate(closed) == 0
        assert page.evaluate("document.documentElement.scrollWidth") <= 1200


def test_table_has_objectives_and_descriptions_and_is_sorted_by_a_click(folder, path):
    F = read_run(folder).outcome.F
    with opened(path) as page:
        headings = page.driver.find_elements("css selector", "#table th")
        assert [heading.text for heading in headings] == [
            *("solution", "mass [kg]", "deflection [m]", "deflection [mm]"),
            *("diameter [m]", "length [m]"),
        ]
        headings[3].find_element("css selector", "button").send_keys(Keys.ENTER)
        rows = np.array(page.evaluate(TABLE))
    np.testing.assert_allclose(rows[:, 3], 1e3 * np.sort(F[:, 1]), rtol=5e-4)
    np.testing.assert_allclose(rows[:, 1], F[rows[:, 0].astype(int), 0], rtol=5e-4)


@pytest.mark.parametrize(
    ("width", "scheme", "ink"),
    [(390, "dark", "rgb(230, 232, 235)"), (1400, "light", "rgb(34, 34, 34)")],
)
def test_page_fits_the_window_and_follows_the_theme(path, width, scheme, ink):
    with opened(path, width, color_scheme=scheme) as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        texts = (
            "document.querySelectorAll('#front :is(.xtitle, .ytitle, .legendtext, .xtick text)')"
        )
        sides = np.array(
            page.evaluate(
                f"[...{texts}].map((t) => t.getBoundingClientRect()).map((b) => [b.left, b.right])"
            )
        )
        assert 0 <= sides.min() < sides.max() <= width  # No label is cut off.
        text = "getComputedStyle(document.querySelector('#front .xtitle')).fill"
        assert page.evaluate(text) == ink
        page.print()
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == (
            "rgb(255, 255, 255)"
        )
        assert page.errors() == []
