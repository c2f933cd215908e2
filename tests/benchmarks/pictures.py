"""Make the pictures of README.md, of the gallery and of the page on reports and the explorer.

    python -m tests.benchmarks.pictures [gallery]

Run it in the root of the repository, with the extras ``png`` and ``explore`` and with Chromium. It
takes a few minutes. With ``gallery`` it makes only the pictures in docs/images/gallery.
"""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
import time
from base64 import b64decode
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from mgeo_attitude.criteria.objectives import attitude_sigma_deg
from mgeo_attitude.view.lower_bound import compute_bound_curves
from selenium.webdriver import Keys

from mgeo.evaluation.dominance import find_front_rows
from mgeo.figures.style import (
    COLORS,
    LOWER_BOUND_COLOR,
    SYMBOLS,
    apply_style,
    build_log_axis_layout,
)
from mgeo.report import build_report_html
from mgeo.report.static import export_figures
from mgeo.runs.prepare import prepare_run
from mgeo.runs.registry import ALGORITHMS as RECORDS

from ..browser import opened
from ..docs.pages import blocks
from ..mgeo.explore.test_server import served

PICTURES = Path(__file__).parents[2] / "docs" / "images"
STUDIES = Path(__file__).parents[2] / "docs" / "studies"
ALGORITHMS = {"mgeo-directed": "mgeo-directed, default", "mgeo-real": "mgeo-real, published"}
#: Run of the gallery, which the report and the explorer show, too.
RUN = Path("runs/first")
#: Part of a report, width and height [px] and color scheme of each picture.
REPORT_PICTURES = {
    "report-front.png": ("header", (1185, 1040), "light"),
    "report-plan.png": ("#solution-section", (1400, 900), "dark"),
    "report-phone.png": ("header", (390, 1290), "light"),
}


def draw_fronts() -> go.Figure:
    """Return a figure of the fronts of two algorithms and of the lower bound for the satellite of
    the paper.
    """
    figure, times = go.Figure(), []
    for index, (algorithm, name) in enumerate(ALGORITHMS.items()):
        run = prepare_run("attitude", algorithm=algorithm)
        X = run.solve().X
        result = run.problem.view(X).nominal
        points = np.column_stack([result.t_end / 60.0, attitude_sigma_deg(result.covariance)])
        times += result.t_end.tolist()
        line = {"shape": "hv", "width": 1, "color": COLORS[index]}
        marker = {"color": COLORS[index], "symbol": SYMBOLS[index], "size": 7}
        x, y = points[find_front_rows(points)].T
        figure.add_scatter(x=x, y=y, mode="lines+markers", name=name, line=line, marker=marker)
    t, _, sigma = compute_bound_curves(run.problem, np.array(times)).T
    figure.add_scatter(x=t / 60.0, y=sigma, mode="lines", line_color=LOWER_BOUND_COLOR)
    figure.data[-1].showlegend = False
    figure.add_annotation(
        text="lower bound", x=t[len(t) // 2] / 60.0, y=np.log10(sigma[len(t) // 2]),
        showarrow=False, xanchor="right", yanchor="top", font_color=LOWER_BOUND_COLOR,
    )  # fmt: skip
    subtitle = "1-sigma of the worst body axis; satellite of the paper, 60,000 evaluations each"
    apply_style(figure, "Attitude accuracy against convergence time", subtitle)
    figure.update_xaxes(title_text="convergence time [min]")
    figure.update_yaxes(build_log_axis_layout(sigma), title_text="attitude accuracy [deg]")
    return figure.update_layout(width=900, height=460, margin_t=80)


def draw_comparison() -> go.Figure:
    """Return a figure of the mean hypervolume against evaluations, from the stored study
    ``budgets`` of the satellite of the paper.
    """
    figure = go.Figure()
    table = pd.read_csv(STUDIES / "data" / "budgets" / "attitude-paper" / "table.csv")
    means = table.groupby(["algorithm", "evaluations"])["hypervolume"].mean().unstack()
    means = means.sort_values(means.columns[-1], ascending=False)
    for index, (label, values) in enumerate(means.iterrows()):
        name = RECORDS[label].label if label in RECORDS else "MGEODirected"
        color = COLORS[0] if index == 0 else COLORS[1 + (index - 1) % (len(COLORS) - 1)]
        line, marker = {"color": color, "width": 2}, {"symbol": SYMBOLS[index], "size": 6}
        figure.add_scatter(
            x=values.index, y=values, mode="lines+markers", name=name, line=line, marker=marker
        )
    subtitle = "mean of 20 runs; satellite of the paper"
    apply_style(figure, "Hypervolume of the front against evaluations", subtitle)
    figure.update_xaxes(title_text="evaluations", tickformat=",d")
    figure.update_yaxes(title_text="hypervolume")
    return figure.update_layout(width=900, height=440, margin_t=80)


def take_picture(page, path, selector, height):
    """Write a part of a page as a PNG file, from the top of an element."""
    page.evaluate(f"document.querySelector('{selector}').scrollIntoView()")
    time.sleep(3.0)  # Figures are drawn when they scroll into view.
    box = f"document.querySelector('{selector}').getBoundingClientRect()"
    top = page.evaluate(f"{box}.top + scrollY")
    clip = {"x": 0, "y": top, "width": page.evaluate("innerWidth"), "height": height, "scale": 1}
    options = {"captureBeyondViewport": True, "clip": clip}
    result = page.driver.execute_cdp_cmd("Page.captureScreenshot", options)
    path.write_bytes(b64decode(result["data"]))


def take_report_pictures(folder, report):
    for name, (selector, (width, height), scheme) in REPORT_PICTURES.items():
        with opened(report, width, color_scheme=scheme) as page:
            page.evaluate("document.querySelector('#figures').scrollIntoView()")
            page.until("document.querySelector('.player')")
            take_picture(page, PICTURES / name, selector, height)
    with served(folder) as url, opened(url, 1400) as page:
        page.until("document.querySelectorAll('#figures .main-svg').length > 6")
        slider = page.driver.find_elements("css selector", "[role=slider]")[3]
        page.driver.execute_script("arguments[0].scrollIntoView()", slider)
        slider.send_keys(Keys.END)
        page.until("document.querySelector('#numbers').textContent.includes('%')")
        take_picture(page, PICTURES / "explore.png", "body", 1100)


def run_commands(selected: str) -> None:
    """Run those commands of the gallery that contain a text, in the current folder."""
    for command in "".join(blocks("gallery.md", "sh")).splitlines():
        if selected in command:
            subprocess.run([sys.executable, "-m", *shlex.split(command), "-q"], check=True)


def take_gallery_pictures() -> None:
    """Execute the examples of the gallery in the current folder, and copy their pictures."""
    run_commands("--png")
    for code in blocks("gallery.md", "python"):
        exec(code, {})
    for path in (*RUN.glob("figures/*.png"), *Path().glob("*.png")):
        shutil.copy(path, PICTURES / "gallery")


def main() -> None:
    with TemporaryDirectory() as temporary:
        os.chdir(temporary)
        run_commands("solve")
        take_gallery_pictures()
        if "gallery" in sys.argv[1:]:
            return
        figures = {"front": draw_fronts(), "comparison": draw_comparison()}
        for name, data in export_figures(figures, ("png",)).items():
            (PICTURES / name).write_bytes(data)
        report = Path("report.html").resolve()
        report.write_text(build_report_html(RUN), encoding="utf-8")
        take_report_pictures(RUN, report)


if __name__ == "__main__":
    main()
