"""The report in headless Chromium: no console errors, and choosing a point changes the plan."""

import re

import numpy as np
import plotly.graph_objects as go
import pytest

from mgeo.report import report_html
from mgeo.store.run_folder import read_run

# plotly takes the point below the pointer when it was moved there a moment ago
_CLICK = """<script>
addEventListener("load", () => setTimeout(() => {
  const front = document.getElementById("front");
  const points = front.querySelectorAll(".scatterlayer .trace .point");
  const at = points[POINT].getBoundingClientRect();
  const target = front.querySelector(".nsewdrag");
  const place = { bubbles: true, clientX: at.x + at.width / 2, clientY: at.y + at.height / 2 };
  target.dispatchEvent(new MouseEvent("mousemove", place));
  setTimeout(() => {
    target.dispatchEvent(new MouseEvent("mousedown", place));
    target.dispatchEvent(new MouseEvent("mouseup", place));
  }, 300);
}, 1500));
</script></body>"""


pytestmark = pytest.mark.slow


@pytest.fixture
def folder(solved, monkeypatch):
    """A run of a problem that draws each solution as a bar of its own height."""
    from stand_in import CantileverView

    def bars(self):
        axis = {"range": [0, 0.05]}
        return [
            {"bar": go.Figure(go.Bar(x=["diameter"], y=[x[0]])).update_yaxes(axis)} for x in self.X
        ]

    monkeypatch.setattr(CantileverView, "solution_figures", bars, raising=False)
    monkeypatch.delattr(CantileverView, "figures")  # mgeo's own picture of the front
    return solved("--record")


def shown(dom):
    """Solution, its diameter as the limits show it, and the drawn bar."""
    row = int(re.search(r'data-shown="(\d+)"', dom)[1])
    diameter = re.search(r"<th scope=\"row\">diameter \[m\]</th><td>([\d.e-]+) within", dom)[1]
    figures = dom.split('id="figures"')[1]
    bar = re.search(r'class="point"><path d="([^"]+)"', figures)[1]
    return row, float(diameter), bar


def test_it_renders_and_another_choice_shows_another_plan(folder, browser):
    html = report_html(folder)
    X = read_run(folder).outcome.X
    seen = {}
    for fragment in ("#solution=0", "#solution=5"):
        dom, messages = browser(html, fragment)
        assert messages == []
        row, diameter, bar = shown(dom)
        assert fragment == f"#solution={row}"
        np.testing.assert_allclose(diameter, X[row, 0], rtol=1e-4)
        seen[row] = bar
    assert seen[0] != seen[5]
    assert dom.count('class="main-svg"') >= 6  # front, history and figure of the solution


def test_a_click_on_the_front_shows_that_plan(folder, browser):
    html = report_html(folder)
    n = len(read_run(folder).outcome.X)
    row = n // 2
    dom, messages = browser(html.replace("</body>", _CLICK.replace("POINT", str(row))))
    assert messages == []
    found, diameter, _ = shown(dom)
    assert found == row
    np.testing.assert_allclose(diameter, read_run(folder).outcome.X[row, 0], rtol=1e-4)


def test_an_error_on_the_page_would_be_seen(report, browser):
    broken = report.replace("</body>", "<script>missing()</script></body>")
    assert any("missing" in message for message in browser(broken)[1])


_PHONE = "<style>html { width: 400px }</style></head>"
_MEASURE = """<script>
addEventListener("load", () => setTimeout(() => {
  const outside = [...document.body.querySelectorAll("*")].filter((node) =>
    !node.closest(".wide, details, svg") && node.getBoundingClientRect().right > 400.5);
  document.body.dataset.outside = outside.map((node) => node.outerHTML.slice(0, 80)).join(" | ");
  const text = document.querySelector("#front .xtitle") || document.querySelector("#front text");
  document.body.dataset.text = getComputedStyle(text).fill;
}, 3000));
</script></body>"""


@pytest.mark.parametrize(("theme", "ink"), [(1, "rgb(34, 34, 34)"), (0, "rgb(230, 232, 235)")])
def test_it_fits_a_phone_and_follows_the_theme(folder, browser, theme, ink):
    html = report_html(folder).replace("</head>", _PHONE).replace("</body>", _MEASURE)
    scheme = f"--blink-settings=preferredColorScheme={theme}"
    dom, messages = browser(html, "", 400, scheme)
    assert messages == []
    assert 'data-outside=""' in dom
    assert f'data-text="{ink}"' in dom
    # the title is above the figure, where the buttons cover nothing
    assert '<text class="gtitle"' not in dom
    assert '<h3 id="heading"></h3>' in dom  # it is that of the page


def test_the_table_has_what_the_problem_says_in_numbers(folder, browser):
    """Objectives, then what is described, then variables; sorted by what is described."""
    click = """<script>
addEventListener("load", () => setTimeout(() => {
  for (const heading of document.querySelectorAll("#table th")) {
    if (heading.textContent === "deflection [mm]") heading.click();
  }
}, 1500));
</script></body>"""
    dom, messages = browser(report_html(folder).replace("</body>", click))
    assert messages == []
    table = dom.split('id="table"')[1]
    assert re.findall(r"<th[^>]*>([^<]*)</th>", table)[:6] == [
        *("solution", "mass [kg]", "deflection [m]", "deflection [mm]"),
        *("diameter [m]", "length [m]"),
    ]
    rows = np.array(re.findall(r"<td>([^<]*)</td>", table.split("</table>")[0]), dtype=float)
    rows = rows.reshape(-1, 6)
    np.testing.assert_allclose(rows[:, 3], 1000.0 * rows[:, 2], rtol=1e-4)
    assert (np.diff(rows[:, 3]) >= 0.0).all()
    F = read_run(folder).outcome.F
    np.testing.assert_allclose(rows[:, 1], F[rows[:, 0].astype(int), 0], rtol=1e-4)
