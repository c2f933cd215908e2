"""The page in headless Chromium: filter, choose, change, save, as a person would."""

import asyncio
import json
import signal

import numpy as np
import plotly.graph_objects as go
import pytest

from mgeo.explore import Explorer
from mgeo.store.run_folder import read_run

from ...devtools import opened
from ..cli.test_process import started
from .conftest import served

pytestmark = pytest.mark.slow

EVIL = "<img src=x onerror=alert(1)>"
_KEPT = "Number(document.body.dataset.kept)"
_CHOSEN = "Number(document.body.dataset.chosen)"
_NUMBERS = (
    "[...document.querySelectorAll('#numbers tbody tr')].map((row) => "
    "[...row.cells].map((cell) => cell.textContent))"
)


def pointer(selector, *places):
    """JavaScript that drags the pointer along an element: down at the first, up at the last."""
    return f"""(() => {{
      const node = document.querySelector({json.dumps(selector)});
      node.setPointerCapture = () => {{}};
      const box = node.getBoundingClientRect();
      const send = (kind, [x, y]) => node.dispatchEvent(new PointerEvent(kind, {{ bubbles: true,
        clientX: box.x + x * box.width, clientY: box.y + y * box.height, pointerId: 1 }}));
      const places = {json.dumps(places)};
      send("pointerdown", places[0]);
      for (const place of places.slice(1)) send("pointermove", place);
      send("pointerup", places.at(-1));
    }})()"""


@pytest.fixture
def drawn(folder, monkeypatch):
    """The run, of beams that are drawn as a bar of their own height."""
    from stand_in import CantileverView

    def bars(self):
        return [{"bar": go.Figure(go.Bar(x=["diameter"], y=[x[0]]))} for x in self.X]

    monkeypatch.setattr(CantileverView, "solution_figures", bars, raising=False)
    return folder


def test_a_person_finds_changes_and_saves_a_solution(drawn, tmp_path):
    asyncio.run(look(drawn, tmp_path))


async def look(folder, tmp_path):
    outcome = read_run(folder).outcome
    F, n = outcome.F, len(outcome.F)
    mass = '#parallel [data-axis="mass [kg]"]'
    with served(Explorer(folder, save=tmp_path)) as client:
        async with opened(client.server.url) as page:
            await page.until("document.body.dataset.limits === 'known'")
            assert await page.evaluate(_KEPT) == n
            axes = "[...document.querySelectorAll('#parallel .name')].map((n) => n.textContent)"
            assert await page.evaluate(axes) == [
                *("mass [kg]", "deflection [m]", "deflection [mm]", "length"),
            ]
            # the lower half of the first axis is kept, by a drag
            await page.evaluate(pointer(mass, [0.5, 1], [0.5, 0.7], [0.5, 0.5]))
            middle = 0.5 * (F[:, 0].min() + F[:, 0].max())
            kept = F[:, 0] <= await page.evaluate(
                "state.columns.find((column) => column.name === 'mass [kg]').range[1]"
            )
            assert await page.evaluate(_KEPT) == kept.sum() < n
            high = await page.evaluate("state.columns[0].range[1]")
            log = await page.evaluate("state.columns[0].log")
            expected = np.sqrt(F[:, 0].min() * F[:, 0].max()) if log else middle
            np.testing.assert_allclose(high, expected, rtol=1e-3)
            # an arrow stays within it
            before = await page.evaluate(_CHOSEN)
            await page.evaluate("choose(0)")
            for _ in range(n):
                await page.evaluate("byId('next').click()")
            assert await page.evaluate(_CHOSEN) == np.flatnonzero(kept)[-1]
            # a click on the axis drops the range, numbers set one
            await page.evaluate(pointer(mass, [0.5, 0.2], [0.5, 0.2]))
            assert await page.evaluate(_KEPT) == n
            field = '[aria-label="deflection [m], at most"]'
            await page.evaluate(
                f"(() => {{ const field = document.querySelector('{field}'); field.value = 0.001;"
                " field.dispatchEvent(new Event('change')); })()"
            )
            assert await page.evaluate(_KEPT) == (F[:, 1] <= 0.001).sum()
            await page.evaluate("byId('clear').click()")
            assert await page.evaluate(_KEPT) == n
            # a point of the front
            await page.evaluate("byId('front').emit('plotly_click', {points: [{customdata: 3}]})")
            assert await page.evaluate(_CHOSEN) == 3 != before
            assert await page.evaluate("location.hash") == "#solution=3"
            # a hand makes it shorter
            await page.set("#variable1", 0.25)
            x = [float(outcome.X[3, 0]), 0.25]
            await page.until(f"document.body.dataset.glanced === [{x[0]!r}, {x[1]!r}].join()")
            rows = await page.evaluate(_NUMBERS)
            weight = 7800.0 * np.pi / 4 * x[0] ** 2 * x[1]
            assert rows[0][0] == "mass [kg]"
            np.testing.assert_allclose(
                [float(rows[0][1]), float(rows[0][2])], [F[3, 0], weight], rtol=1e-3
            )
            assert "0.25 m, at most 0.5 m" in await page.evaluate("byId('limits').textContent")
            shape = "byId('front').data.at(-1)"
            assert await page.evaluate(f"{shape}.name") == "changed"
            np.testing.assert_allclose(await page.evaluate(f"{shape}.x[0]"), weight, rtol=1e-12)
            await page.until(f"document.body.dataset.shown === JSON.stringify({x})")
            bar = "document.querySelector('#figures .js-plotly-plot').data[0].y[0]"
            assert await page.evaluate(bar) == pytest.approx(x[0])
            # what lies beyond its bounds is told, and is not saved
            number = "document.querySelector('#editor input[type=number]')"
            send = f"{number}.dispatchEvent(new Event('input'))"
            await page.evaluate(f"{number}.value = 7; {send}")
            await page.until("!byId('error').hidden")
            told = await page.evaluate("byId('error').textContent")
            assert told == "design[0] = 7: expected 0.01 to 0.05 for diameter [m]"
            await page.evaluate(f"{number}.value = 0.02; {send}")
            await page.until("byId('error').hidden")
            for press in ("write", "write", "replace"):
                await page.evaluate(f"byId('saved').textContent = ''; byId('{press}').click()")
                await page.until("byId('saved').textContent !== ''")
            assert await page.evaluate("byId('saved').textContent") == (
                f"written: {tmp_path / 'plan.json'}"
            )
            document = json.loads((tmp_path / "plan.json").read_text())
            assert document["design"] == [0.02, 0.25]
            await page.evaluate("byId('reset').click()")
            assert await page.evaluate("design()") == outcome.X[3].tolist()
            await page.evaluate("byId('review').open = true")
            await page.until("byId('review').textContent.includes('Solution')")
            await page.evaluate("byId('pictures').open = true")
            await page.until("document.querySelector('#pictures .js-plotly-plot') !== null")
            # the browser itself notes what was refused
            refused = [
                e for e in page.errors if "status of 4" in e.get("entry", {}).get("text", "")
            ]
            assert page.errors == refused
            assert len(refused) >= 2  # a design, and a name


_OUTSIDE = """[...document.body.querySelectorAll("*")].filter((node) =>
  !node.closest(".wide, details, svg") && node.getBoundingClientRect().right > innerWidth + 0.5
).map((node) => node.outerHTML.slice(0, 80))"""


@pytest.mark.parametrize(
    ("width", "scheme", "paper"),
    [(390, "dark", "rgb(22, 25, 29)"), (1400, "light", "rgb(255, 255, 255)")],
)
def test_it_fits_a_phone_and_a_desk_and_follows_the_theme(drawn, width, scheme, paper):
    async def look():
        with served(Explorer(drawn)) as client:
            async with opened(client.server.url, width, prefers_color_scheme=scheme) as page:
                await page.until("document.body.dataset.limits === 'known'")
                assert await page.evaluate(_OUTSIDE) == []
                assert await page.evaluate("document.documentElement.scrollWidth") <= width
                assert (
                    await page.evaluate("getComputedStyle(document.body).backgroundColor") == paper
                )
                lying = await page.evaluate("parallel.lying")
                assert lying == (width < 600)
                if lying:  # a finger keeps the left half
                    axis = '#parallel [data-axis="mass [kg]"]'
                    await page.evaluate(pointer(axis, [0, 0.5], [0.3, 0.5], [0.5, 0.5]))
                    kept = await page.evaluate(_KEPT)
                    assert 0 < kept < await page.evaluate("state.n")
                assert page.errors == []

    asyncio.run(look())


def test_hostile_texts_stay_text(drawn, monkeypatch):
    from stand_in import CantileverView

    monkeypatch.setattr(CantileverView, "answers", lambda self: [EVIL] * len(self.X))
    described = CantileverView.describe
    monkeypatch.setattr(
        CantileverView, "describe", lambda self: described(self).assign(**{EVIL: 1.0, "t": EVIL})
    )

    async def look():
        with served(Explorer(drawn)) as client:
            async with opened(client.server.url) as page:
                await page.until("byId('answer').textContent !== ''")
                assert await page.evaluate("byId('answer').textContent") == EVIL
                assert await page.evaluate("byId('numbers').textContent.includes('<img')")
                assert await page.evaluate("document.querySelector('img[src=x]')") is None
                assert page.errors == []

    asyncio.run(look())


def test_it_says_when_the_server_has_ended(folder, stand_in_environment, tmp_path):
    async def look(process):
        async with opened(process.stdout.readline().strip()) as page:
            await page.until("document.body.dataset.limits === 'known'")
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=60)
            await page.evaluate("choose(1)")
            await page.until("!byId('error').hidden")
            told = await page.evaluate("byId('error').textContent")
            assert told.startswith("mgeo explore has ended")

    arguments = ["explore", str(folder), "--no-browser"]
    with started(arguments, stand_in_environment, tmp_path) as process:
        asyncio.run(look(process))
