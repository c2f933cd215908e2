"""A moving figure in a browser: still until it is told to play, and where it should be."""

import asyncio

import numpy as np
import plotly.graph_objects as go
import pytest

from mgeo.report import report_html

from ...devtools import opened

pytestmark = pytest.mark.slow

_TIP = "(({ x, y, z, opacity }) => [x[1], y[1], z[1], opacity])(PLOT.data[0])".replace(
    "PLOT", 'document.querySelector(".moving .js-plotly-plot")'
)
_TOLD = 'document.querySelector(".player output").textContent'
_BUTTON = 'document.querySelector(".player button")'
_SPEED = 'document.querySelector(".player select")'
_TIME = 'Number(document.querySelector(".player input").value)'


@pytest.fixture
def page(solved, monkeypatch, tmp_path):
    """Path of a report in which a hand turns by 90 degrees in 100 s, then back by 450 in 100 s."""
    from stand_in import CantileverView

    turns = {"hand": {"times": np.array([0.0, 100, 200]), "x": [0.0, 0], "y": [0.0, 0]}}
    turns["hand"]["z"] = np.array([90.0, -450.0])
    phases = [{"name": "dusk", "from": 20.0, "to": 60.0, "shaded": True}]
    hand = {"meta": {"turn": "hand", "faint": "dusk"}, "mode": "lines"}
    figure = go.Figure(
        go.Scatter3d(x=np.array([0.0, 2.0]), y=[0, 0], z=[0.0, 1.0], **hand),
        {"meta": {"motion": {"end": 200.0, "turns": turns, "phases": phases}}},
    )
    drawn = lambda self: [{"hand": figure} for _ in self.X]  # noqa: E731
    monkeypatch.setattr(CantileverView, "solution_figures", drawn, raising=False)
    path = tmp_path / "page.html"
    path.write_text(report_html(solved()), encoding="utf-8")
    return path


def test_it_moves_when_told_to_and_as_told(page):
    asyncio.run(look(page))


async def look(path):
    async with opened(path, prefers_reduced_motion="reduce") as page:
        assert await page.evaluate("document.querySelector('.player')") is None  # not yet in view
        await page.evaluate("document.querySelector('.moving').scrollIntoView()")
        await page.until("document.querySelector('.player') !== null")
        await asyncio.sleep(0.5)
        assert await page.evaluate(_TOLD) == "0 s"
        np.testing.assert_allclose(await page.evaluate(_TIP), [2, 0, 1, 1], atol=1e-6)

        half = np.sqrt(2.0)
        for time, expected in [
            (50.0, [half, half, 1, 0.2]),
            (100.0, [0, 2, 1, 1]),
            (120.0, [2, 0, 1, 1]),
            (200.0, [2, 0, 1, 1]),
        ]:
            await page.set(".player input", time)
            named = " · dusk" if time == 50 else ""
            assert await page.evaluate(_TOLD) == f"{time:.0f} s{named}"
            await page.close(_TIP, expected, 1e-5)

        await page.evaluate(f"{_SPEED}.value = 10; {_BUTTON}.click()")  # from the start again
        await page.until(f"{_TIME} > 0 && {_TIME} < 150")
        assert await page.evaluate(f"{_BUTTON}.textContent") == "Pause"
        await page.evaluate(f"{_BUTTON}.click()")
        stopped = await page.evaluate(_TIME)
        await asyncio.sleep(0.5)
        assert await page.evaluate(_TIME) == stopped > 0
        await page.evaluate(f"{_SPEED}.value = 200; {_BUTTON}.click()")
        await page.until(f"{_TIME} === 200")
        assert await page.evaluate(f"{_BUTTON}.textContent") == "Play"

        await page.evaluate(f"{_BUTTON}.click(); choose(1)")  # another plan begins at its start
        await page.until(
            "document.body.dataset.shown === '1' && document.querySelector('.player') !== null"
        )
        await asyncio.sleep(0.5)
        assert await page.evaluate(_TOLD) == "0 s"
        assert await page.evaluate("document.querySelectorAll('.player').length") == 1
        assert page.errors == []
