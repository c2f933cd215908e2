"""Animated figure of the report in headless Chromium."""

import time

import numpy as np
import plotly.graph_objects as go
import pytest

from mgeo.report import build_report_html

from ...browser import opened

pytestmark = pytest.mark.slow

_TIP = "(({ x, y, z, opacity }) => [x[1], y[1], z[1], opacity])(PLOT.data[0])".replace(
    "PLOT", 'document.querySelector(".moving .js-plotly-plot")'
)
_STATUS = 'document.querySelector(".player output").textContent'
_BUTTON = 'document.querySelector(".player button")'
_SPEED = 'document.querySelector(".player select")'
_TIME = 'Number(document.querySelector(".player input").value)'


@pytest.fixture
def path(solved, monkeypatch, tmp_path):
    """Path of a report with a line that turns by 90 degrees in 100 s, then by -450 in 100 s."""
    from stand_in import CantileverView

    rotations = {"hand": {"times": np.array([0.0, 100, 200]), "x": [0.0, 0], "y": [0.0, 0]}}
    rotations["hand"]["z"] = np.array([90.0, -450.0])
    phases = [{"name": "dusk", "from": 20.0, "to": 60.0, "shaded": True}]
    hand = {"meta": {"rotation": "hand", "faint": "dusk"}, "mode": "lines"}
    figure = go.Figure(
        go.Scatter3d(x=np.array([0.0, 2.0]), y=[0, 0], z=[0.0, 1.0], **hand),
        {"meta": {"motion": {"end": 200.0, "rotations": rotations, "phases": phases}}},
    )
    draw = lambda self: [{"hand": figure} for _ in self.X]  # noqa: E731
    monkeypatch.setattr(CantileverView, "solution_figures", draw, raising=False)
    path = tmp_path / "page.html"
    path.write_text(build_report_html(solved()), encoding="utf-8")
    return path


def test_player_moves_the_figure(path):
    with opened(path, 390, reduced_motion="reduce") as page:  # The figure is far below the front.
        assert page.evaluate("document.querySelector('.player')") is None
        page.evaluate("document.querySelector('.moving').scrollIntoView()")
        page.until("document.querySelector('.player') !== null")
        time.sleep(0.5)
        assert page.evaluate(_STATUS) == "0 s"
        np.testing.assert_allclose(page.evaluate(_TIP), [2, 0, 1, 1], atol=1e-6)

        half = np.sqrt(2.0)
        for moment, expected in [
            (50.0, [half, half, 1, 0.2]),
            (100.0, [0, 2, 1, 1]),
            (120.0, [2, 0, 1, 1]),
            (200.0, [2, 0, 1, 1]),
        ]:
            page.set(".player input", moment)
            phase = " · dusk" if moment == 50 else ""
            assert page.evaluate(_STATUS) == f"{moment:.0f} s{phase}"
            page.until_close(_TIP, expected, 1e-5)

        page.run(f"{_SPEED}.value = 10; {_BUTTON}.click()")  # It plays again from the start.
        page.until(f"{_TIME} > 0 && {_TIME} < 150")
        assert page.evaluate(f"{_BUTTON}.textContent") == "Pause"
        page.run(f"{_BUTTON}.click()")
        stopped = page.evaluate(_TIME)
        time.sleep(0.5)
        assert page.evaluate(_TIME) == stopped > 0
        page.run(f"{_SPEED}.value = 200; {_BUTTON}.click()")
        page.until(f"{_TIME} === 200")
        assert page.evaluate(f"{_BUTTON}.textContent") == "Play"

        page.run(f"{_BUTTON}.click(); choose(1)")  # The next solution starts at 0 s.
        page.until(
            "document.body.dataset.shown === '1' && document.querySelector('.player') !== null"
        )
        time.sleep(0.5)
        assert page.evaluate(_STATUS) == "0 s"
        assert page.evaluate("document.querySelectorAll('.player').length") == 1
        assert page.errors() == []
