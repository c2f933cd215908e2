"""Takes the picture of a report's front of docs/report.md.

    python -m tests.benchmarks.report_picture RUN/report.html

of a report of `mgeo solve attitude --scenario docs/scenarios/mine.toml`. It needs a browser.
"""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path

from PIL import Image

from ..devtools import opened

PICTURE = Path(__file__).parents[2] / "docs" / "images" / "report-front.png"
WIDTH, HEIGHT = 1185, 660  # px


async def take(report: Path) -> None:
    """Write the picture: the front as the report's page shows it."""
    async with opened(report, WIDTH) as page:
        await page.until("document.querySelector('#front .main-svg')")
        top = await page.evaluate(
            "document.querySelector('#front').getBoundingClientRect().top + window.scrollY"
        )
        await page.picture(PICTURE)
    y = max(0, round(top) - 60)
    Image.open(PICTURE).crop((0, y, WIDTH, y + HEIGHT)).save(PICTURE)


if __name__ == "__main__":
    asyncio.run(take(Path(sys.argv[1]).resolve()))
