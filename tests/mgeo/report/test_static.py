"""Export of figures as PNG and PDF files."""

import struct
import sys

import plotly.graph_objects as go
import pytest

from mgeo.figures.style import HOVER_HINT, apply_style, format_for_print
from mgeo.report.static import draw_run_figures, export_figures, prepare_figures

from ...browser import find_browser
from .conftest import mgeo


@pytest.fixture
def folder(solved, monkeypatch):
    """Recorded run of a problem with a static and an animated figure of each solution."""
    from stand_in import CantileverView

    def draw_figures(self):
        static = go.Figure(go.Bar(x=["diameter"], y=[1.0]), {"height": 300})
        animated = go.Figure(layout={"meta": {"motion": {"end": 1.0, "rotations": {}}}})
        return [{"../Bar!": static, "animated": animated} for _ in self.X]

    monkeypatch.setattr(CantileverView, "solution_figures", draw_figures, raising=False)
    return solved("--record")


def check_refused(folder, done):
    """Check that a command printed one line and wrote no files, and return the line."""
    assert (done.exit_code, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert not (folder / "report.html").exists()
    assert not (folder / "figures").exists()
    return done.stderr


def test_error_without_kaleido_names_the_extra(folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "kaleido", None)
    assert "pip install 'mgeo[png]'" in check_refused(folder, mgeo("report", folder, "--png"))


def test_error_without_a_browser_names_the_browsers(folder, monkeypatch):
    pytest.importorskip("kaleido")
    monkeypatch.setenv("BROWSER_PATH", "/bin/false")
    assert "need Chrome or Chromium" in check_refused(folder, mgeo("report", folder, "--pdf"))


def test_error_for_unknown_figure_suggests_the_nearest_name(folder):
    names = {"front", "hypervolume", "knee-bar", "min-mass-bar", "min-deflection-bar"}
    assert set(draw_run_figures(folder)) == names
    message = check_refused(folder, mgeo("report", folder, "--figure", "knee-bra"))
    assert "'knee-bra'" in message
    assert "did you mean 'knee-bar'" in message


@pytest.mark.slow
def test_figures_are_written_next_to_the_report(folder, tmp_path):
    find_browser()
    out = tmp_path / "review" / "of-a-run.html"
    out.parent.mkdir()
    done = mgeo("report", folder, "--png", "--out", out)
    assert done.exit_code == 0, done.output
    files = {path.name: path.read_bytes() for path in (out.parent / "figures").iterdir()}
    assert set(files) == {f"{name}.png" for name in draw_run_figures(folder)}
    assert struct.unpack(">II", files["front.png"][16:24]) == (1800, 1120)
    assert struct.unpack(">II", files["knee-bar.png"][16:24]) == (1280, 600)


@pytest.mark.slow
def test_paper_option_writes_one_pdf(folder):
    find_browser()
    done = mgeo("report", folder, "--figure", "knee-bar", "--paper")
    assert done.exit_code == 0, done.output
    (path,) = (folder / "figures").iterdir()
    assert path.name == "knee-bar.pdf"
    assert path.read_bytes().startswith(b"%PDF-1.")
    assert not (folder / "report.html").exists()


def test_figure_for_a_paper_is_a_column_wide_without_controls():
    figure = go.Figure(go.Scatter(x=[1, 2], y=[3, 4], marker={"size": 10}))
    apply_style(figure, "A title", f"points{HOVER_HINT}")
    figure.update_layout(updatemenus=[{"buttons": [{"label": "a", "method": "update"}]}])
    static = prepare_figures({"a": figure}, paper=False)["a"]
    assert not static.layout.updatemenus
    assert static.layout.title.text.endswith("13px'>points</span>")
    printed = format_for_print(figure)
    assert printed.layout.title.text is None
    assert printed.layout.width / 96 * 25.4 == pytest.approx(88.0, abs=0.2)  # mm
    assert printed.layout.font.size * 0.75 == pytest.approx(8.0, abs=0.1)  # points
    assert printed.data[0].marker.size == 6.0
    assert figure.data[0].marker.size == 10  # The original figure is unchanged.


@pytest.mark.slow
def test_printed_axis_has_a_label_at_its_end():
    find_browser()
    figure = go.Figure(go.Scatter(x=[0, 3000], y=[0, 1], mode="lines"))
    figure = apply_style(figure, "", "").update_xaxes(tickformat=",d")
    files = export_figures(prepare_figures({"line": figure}, paper=True), ["svg"])
    assert b">3,000</text>" in files["line.svg"]
