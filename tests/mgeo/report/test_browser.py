"""Report of a run in headless Chromium: selection of solutions, table, and layout."""

import numpy as np
import plotly.graph_objects as go
import pytest
from selenium.webdriver import ActionChains

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


def test_table_has_objectives_and_descriptions_and_is_sorted_by_a_click(folder, path):
    F = read_run(folder).outcome.F
    with opened(path) as page:
        headings = page.driver.find_elements("css selector", "#table th")
        assert [heading.text for heading in headings] == [
            *("solution", "mass [kg]", "deflection [m]", "deflection [mm]"),
            *("diameter [m]", "length [m]"),
        ]
        headings[3].click()
        rows = np.array(page.evaluate(TABLE))
    np.testing.assert_allclose(rows[:, 3], 1e3 * np.sort(F[:, 1]), rtol=1e-4)
    np.testing.assert_allclose(rows[:, 1], F[rows[:, 0].astype(int), 0], rtol=1e-4)


@pytest.mark.parametrize(
    ("width", "scheme", "ink"),
    [(390, "dark", "rgb(230, 232, 235)"), (1400, "light", "rgb(34, 34, 34)")],
)
def test_page_fits_the_window_and_follows_the_theme(path, width, scheme, ink):
    with opened(path, width, color_scheme=scheme) as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        text = "getComputedStyle(document.querySelector('#front .xtitle')).fill"
        assert page.evaluate(text) == ink
        page.print()
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == (
            "rgb(255, 255, 255)"
        )
        assert page.errors() == []
