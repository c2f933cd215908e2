"""Executed pages are kept by the content that they show."""

import shutil
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def content(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs" / "_extensions")
    import content

    yield content
    sys.modules.pop("content")


def test_another_file_version_or_size_is_another_name(content, tmp_path, monkeypatch):
    shutil.copytree(ROOT / "docs" / "scenarios", tmp_path / "scenarios")
    monkeypatch.setattr(content, "version", lambda package: "1")  # not all are installed here
    named = content.digest(tmp_path, ["scenarios"])
    assert content.digest(tmp_path, ["scenarios"]) == named
    (tmp_path / "scenarios" / "__pycache__").mkdir()
    (tmp_path / "scenarios" / "__pycache__" / "x.py").touch()
    (tmp_path / "scenarios" / "notes.txt").write_text("no page shows it")
    assert content.digest(tmp_path, ["scenarios"]) == named
    file = tmp_path / "scenarios" / "limits.toml"
    file.write_text(file.read_text().replace("0.05", "0.06", 1))
    names = [named, content.digest(tmp_path, ["scenarios"])]
    for newer in (None, "myst-nb", "ppigrf"):
        monkeypatch.setattr(content, "version", lambda package, newer=newer: str(package == newer))
        names.append(content.digest(tmp_path, ["scenarios"]))
    monkeypatch.setenv("MGEO_NOTEBOOK_SMALL", "")  # set is set, as kernels see it
    names.append(content.digest(tmp_path, ["scenarios"]))
    assert len(set(names)) == len(names)


def test_all_that_pages_show_counts(content):
    for source in content.SOURCES:
        assert any((ROOT / source).rglob("*")), source
    with_data = {path for path in (ROOT / "docs").rglob("*.csv") if "_build" not in path.parts}
    inside = [ROOT / source for source in content.SOURCES]
    shown = {p for p in with_data if any(p.is_relative_to(folder) for folder in inside)}
    assert {path.name for path in shown} >= {"limits.csv", "free.csv", "table.csv"}
