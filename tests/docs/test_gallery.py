"""The commands and the code of docs/gallery.md make the pictures that the page shows."""

import re
from pathlib import Path

import pytest

from ..browser import find_browser
from .pages import DOCS, blocks, run


@pytest.mark.slow
def test_examples_make_the_pictures(tmp_path, monkeypatch):
    pytest.importorskip("kaleido", reason="pip install 'mgeo[png]'")
    find_browser()
    monkeypatch.chdir(tmp_path)
    for command in "".join(blocks("gallery.md", "sh")).splitlines():
        if "explore" not in command:  # a server
            run(command)
    for code in blocks("gallery.md", "python"):
        exec(code.replace("4_000", "400").replace("seeds=10", "seeds=2"), {})
    made = {path.name for path in (*Path().glob("*.png"), *Path().glob("runs/first/figures/*"))}
    page = (DOCS / "gallery.md").read_text(encoding="utf-8")
    assert made == set(re.findall(r"\(images/gallery/(\S+)\)", page))


def test_pictures_are_small():
    pictures = list((DOCS / "images" / "gallery").iterdir())
    assert len(pictures) == 8
    assert max(path.stat().st_size for path in pictures) < 300_000
