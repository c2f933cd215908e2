"""Pictures of a run's figures, and what is said where they cannot be drawn."""

import asyncio
import inspect
import logging
import re
import struct
import sys
import threading
import types

import plotly.graph_objects as go
import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.figures.style import COLORS, HOVER, finished, for_paper, symbol
from mgeo.report.static import StaticExportError, drawn_by, shaped

from ...browser import find_browser


def report(*arguments):
    return CliRunner().invoke(app, ["report", *map(str, arguments)])


@pytest.fixture
def folder(solved, monkeypatch):
    """A recorded run of a problem with a still and a moving figure of each solution."""
    from stand_in import CantileverView

    def figures(self):
        still = go.Figure(go.Bar(x=["diameter"], y=[1.0]), {"height": 300})
        moving = go.Figure(go.Scatter3d(x=[1.0], y=[0.0], z=[0.0], meta={"turn": "a"}))
        turn = {"times": [0.0, 1.0], "x": [9.0], "y": [0.0], "z": [0.0]}
        moving.update_layout(meta={"motion": {"end": 1.0, "turns": {"a": turn}}})
        return [{"../Bar!": still, "bar": still, "moving": moving} for _ in self.X]

    monkeypatch.setattr(CantileverView, "solution_figures", figures, raising=False)
    return solved("--record")


def refused(folder, done):
    """The one line of a command that has written nothing."""
    assert (done.exit_code, done.stdout) == (2, "")
    assert not (folder / "report.html").exists()
    assert not (folder / "figures").exists()
    assert done.stderr.count("\n") == 1
    return done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("installed", [None, types.ModuleType("kaleido")])
def test_without_kaleido_it_says_what_to_install(folder, monkeypatch, installed):
    monkeypatch.setitem(sys.modules, "kaleido", installed)
    assert "pip install 'mgeo[png]'" in refused(folder, report(folder, "--png"))
    assert report(folder).exit_code == 0  # the page needs none


@pytest.mark.parametrize(
    "path", ["/nowhere/chrome", "/bin/false", pytest.param("silent", marks=pytest.mark.slow)]
)
def test_without_a_browser_it_says_so(folder, tmp_path, monkeypatch, path):
    pytest.importorskip("kaleido")
    silent = tmp_path / "silent"
    silent.write_text("#!/bin/sh\nexec sleep 1000\n")
    silent.chmod(0o755)
    monkeypatch.setattr("mgeo.report.static._PATIENCE", 2.0)
    monkeypatch.setenv("BROWSER_PATH", str(silent) if path == "silent" else path)
    before = set(threading.enumerate())  # those of other tests, such as pools of processes
    message = refused(folder, report(folder, "--pdf"))
    assert message.startswith("Error: PNG and PDF need Chrome or Chromium, and none was found")
    for thread in set(threading.enumerate()) - before:
        if not thread.daemon:  # one that goes on would keep the process from ending
            thread.join(30.0)
            assert not thread.is_alive()


@pytest.mark.slow
def test_pictures_are_written_beside_the_report(folder, tmp_path):
    pytest.importorskip("kaleido")
    find_browser()
    out = tmp_path / "review" / "of-a-run.html"
    out.parent.mkdir()
    done = report(folder, "--png", "--pdf", "--out", out)
    assert done.exit_code == 0, done.output
    written = {path.name: path.read_bytes() for path in (out.parent / "figures").iterdir()}
    stems = {name.removesuffix(".png") for name in written if name.endswith(".png")}
    assert {name.removesuffix(".pdf") for name in written} - {f"{s}.png" for s in stems} == stems
    assert {"front", "hypervolume", "knee-bar", "knee-bar-2"} < stems
    assert not any("moving" in stem for stem in stems)
    for name, content in written.items():
        if name.endswith(".pdf"):
            assert content.startswith(b"%PDF-1.")
            assert content.rstrip().endswith(b"%%EOF")
        else:
            assert content.startswith(b"\x89PNG\r\n\x1a\n")
    assert struct.unpack(">II", written["front.png"][16:24]) == (1800, 1120)
    assert struct.unpack(">II", written["knee-bar.png"][16:24]) == (1280, 600)
    assert f"written: {out.parent / 'figures'} ({len(written)} files)" in done.stdout
    assert not (folder / "figures").exists()


def test_a_folder_that_cannot_be_made_leaves_no_report(folder, monkeypatch):
    (folder / "figures").write_text("a file in the way")
    made = {"front.png": b"drawn"}
    monkeypatch.setattr("mgeo.report.static.static_figures", lambda *_, **__: made)
    done = report(folder, "--png")
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert not (folder / "report.html").exists()
    assert (folder / "figures").read_text() == "a file in the way"


@pytest.mark.slow
def test_one_figure_for_a_paper(folder):
    pytest.importorskip("kaleido")
    find_browser()
    done = report(folder, "--figure", "knee-bar", "--paper")
    assert done.exit_code == 0, done.output
    assert [path.name for path in (folder / "figures").iterdir()] == ["knee-bar.pdf"]
    assert not (folder / "report.html").exists()
    done = report(folder, "--figure", "knee-bar", "--figure", "front")
    assert done.exit_code == 0, done.output
    assert (folder / "figures" / "front.png").exists()


@pytest.mark.parametrize(
    "error", [RuntimeError("none"), ChildProcessError("ended"), TimeoutError()]
)
def test_a_browser_that_cannot_be_spoken_with_is_none(error):
    """It may have closed the channel before or after it is opened: then the errors differ."""

    def no_browser(**options):
        raise error

    with pytest.raises(StaticExportError, match="none was found that starts"):
        asyncio.run(drawn_by({}, ["png"], no_browser))


def test_only_an_unreadable_message_of_the_browser_is_kept_out_of_the_log(caplog):
    pipe = pytest.importorskip("choreographer.channels.pipe")
    assert "JSONError decoding message" in inspect.getsource(pipe)

    def no_browser(**options):
        raise RuntimeError("none")

    with pytest.raises(StaticExportError):
        asyncio.run(drawn_by({}, ["png"], no_browser))
    log = logging.getLogger(pipe.__name__)
    log.error("JSONError decoding message. Ignoring")
    log.warning("something else")
    logging.getLogger("choreographer.browser_async").warning("another")
    assert [record.getMessage() for record in caplog.records] == ["something else", "another"]


def test_a_figure_that_there_is_not(folder):
    message = refused(folder, report(folder, "--figure", "knee-bra"))
    assert re.search(r"no figure 'knee-bra': expected front, .*; did you mean 'knee-bar'", message)


def test_what_only_a_screen_can_do_is_not_printed():
    figure = go.Figure(go.Scatter(x=[1, 2], y=[3, 4], marker={"size": 10}))
    finished(figure, "A title", f"points{HOVER}")
    figure.update_layout(xaxis2={"side": "top"})
    figure.update_layout(updatemenus=[{"buttons": [{"label": "a", "method": "update"}]}])
    still = shaped({"a": figure}, paper=False)["a"]
    assert not still.layout.updatemenus
    assert still.layout.title.text.endswith("13px'>points</span>")
    printed = for_paper(figure)
    assert (printed.layout.title.text, printed.layout.width) == (None, 333)
    assert printed.layout.width / 96 * 25.4 == pytest.approx(88.0, abs=0.2)
    assert printed.layout.font.size * 0.75 == pytest.approx(8.0, abs=0.1)  # points
    assert printed.data[0].marker.size == 6.0
    assert figure.data[0].marker.size == 10  # the figure itself is as it was
    assert HOVER in figure.layout.title.text


def test_nothing_lies_below_the_legend_of_a_figure_for_a_paper():
    """Where an axis above leaves it room inside alone, no text stands along a line there."""
    figure = go.Figure([go.Scatter(x=[1, 2], y=[3, 4], name=name) for name in "ab"])
    figure.add_vline(x=1.5, annotation={"text": "a period", "textangle": -90})
    figure.add_annotation(x=1.2, y=3.0, text="a point")
    assert len(for_paper(figure).layout.annotations) == 2
    figure.update_layout(xaxis2={"side": "top"})
    printed = for_paper(figure)
    assert [each.text for each in printed.layout.annotations] == ["a point"]
    assert len(printed.layout.shapes) == 1
    assert printed.layout.margin.l == 52
    figure.update_xaxes(visible=False)
    assert for_paper(figure).layout.margin.l < 10  # a map fills the column


def test_no_two_of_many_lines_look_alike():
    looks = {(COLORS[i % len(COLORS)], symbol(i)) for i in range(49)}
    assert len(looks) == 49
