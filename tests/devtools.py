"""A page in a browser that runs in real time and can be asked: for what moves."""

import asyncio
import json
from base64 import b64decode
from contextlib import asynccontextmanager

import numpy as np
import pytest

from .browser import find_browser

_PATIENCE = 120.0  # seconds, on a busy machine


class Page:
    """A page of a browser."""

    def __init__(self, tab):
        self._tab = tab
        self.errors = []

    async def evaluate(self, expression):
        """Value of a JavaScript expression, waiting for a promise."""
        params = {"expression": expression, "awaitPromise": True, "returnByValue": True}
        answer = (await self._tab.send_command("Runtime.evaluate", params))["result"]
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    async def until(self, condition):
        """Wait until a JavaScript expression holds, and give its value."""
        async with asyncio.timeout(_PATIENCE):
            while not (value := await self.evaluate(condition)):
                await asyncio.sleep(0.1)
        return value

    async def close(self, expression, expected, atol):
        """Wait until numbers are what they should be; fails if they never are."""
        for _ in range(int(_PATIENCE / 0.1)):
            if np.allclose(await self.evaluate(expression), expected, rtol=0.0, atol=atol):
                return
            await asyncio.sleep(0.1)
        found = await self.evaluate(expression)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=atol)

    async def picture(self, path):
        """Write the whole page as a PNG."""
        size = await self.evaluate("document.documentElement.scrollHeight")
        width = await self.evaluate("window.innerWidth")
        clip = {"x": 0, "y": 0, "width": width, "height": size, "scale": 1}
        params = {"format": "png", "captureBeyondViewport": True, "clip": clip}
        found = await self._tab.send_command("Page.captureScreenshot", params)
        path.write_bytes(b64decode(found["result"]["data"]))

    async def on_paper(self):
        """Show it as it is printed."""
        await self._tab.send_command("Emulation.setEmulatedMedia", {"media": "print"})
        await self.evaluate("dispatchEvent(new Event('beforeprint'))")

    async def set(self, selector, value):
        """Move a slider."""
        found = f"document.querySelector({json.dumps(selector)})"
        event = f"{found}.dispatchEvent(new Event('input'))"
        await self.evaluate(f"{found}.value = {value}; {event}")


@asynccontextmanager
async def opened(path, width=1200, **features):
    """A page of a width, by its path or address, with features of media.

    Such as ``prefers_color_scheme="dark"``.

    Its errors are kept.
    """
    choreographer = pytest.importorskip("choreographer")
    browser = choreographer.Browser(path=find_browser())
    await browser.open()
    try:
        tab = await browser.create_tab("about:blank")
        page = Page(tab)

        async def keep(event):
            found = event["params"]
            told = found.get("entry", found)
            if told.get("level", told.get("type", "error")) == "error":
                page.errors.append(found)

        for name in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded"):
            tab.subscribe(name, keep, repeating=True)
        for domain in ("Page", "Runtime", "Log"):
            await tab.send_command(f"{domain}.enable")
        size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600}
        await tab.send_command("Emulation.setDeviceMetricsOverride", size)
        named = [{"name": k.replace("_", "-"), "value": v} for k, v in features.items()]
        await tab.send_command("Emulation.setEmulatedMedia", {"features": named})
        url = path if str(path).startswith("http://") else f"file://{path}"
        await tab.send_command("Page.navigate", {"url": url})
        await page.until("document.body && document.body.dataset.shown")
        yield page
    finally:
        await browser.close()
