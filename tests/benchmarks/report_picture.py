"""Takes the pictures of docs/report.md: a report's front, a plan in the dark, and a phone's.

    python -m tests.benchmarks.report_picture RUN/report.html

of a report of `mgeo solve attitude --scenario docs/scenarios/mine.toml --robust`. It needs a
browser.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from PIL import Image

from ..browser import opened

PICTURES = Path(__file__).parents[2] / "docs" / "images"
#: Of each picture: what it begins with, how many pixels above that; width and height; colors.
TAKEN = {
    "report-front.png": ("#front", 60, (1185, 660), "light"),
    "report-plan.png": ("#figures", 60, (1400, 660), "dark"),
    "report-phone.png": ("#figures", 10, (390, 900), "light"),
}


def take(report: Path, name: str) -> None:
    """Write a picture: a part of the report's page."""
    first, above, (width, height), colors = TAKEN[name]
    with opened(report, width, color_scheme=colors) as page:
        page.until("document.querySelector('#front .main-svg')")
        page.evaluate(f"document.querySelector('{first}').scrollIntoView()")
        page.evaluate(f"window.scrollBy(0, -{above})")
        time.sleep(3.0)  # figures are drawn as they come into view
        top = page.evaluate(
            f"document.querySelector('{first}').getBoundingClientRect().top + window.scrollY"
        )
        page.picture(PICTURES / name)
    y = max(0, round(top) - above)
    Image.open(PICTURES / name).crop((0, y, width, y + height)).save(PICTURES / name)


if __name__ == "__main__":
    for _name in TAKEN:
        take(Path(sys.argv[1]).resolve(), _name)
