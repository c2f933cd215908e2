"""The commands of docs/reference/command-line.md, and the pages of JSON documents and files."""

import json
import re
from pathlib import Path

import pytest

from mgeo.validation.documents import collect_documents

from .pages import DOCS, blocks, run

STUDY = """
title = "Two algorithms"
evaluations = 300
seeds = 4
[[problems]]
name = "pymoo:zdt1"
[[algorithms]]
name = ["mgeo-real", "nsga2"]
"""


def invoke(line):
    command, _, file = line.replace("1080 --out", "480 --out").partition(" > ")
    printed = run(command)
    if file:
        Path(file).write_text(printed)
    return printed


@pytest.mark.slow
def test_commands(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("study.toml").write_text(STUDY)
    for block in blocks("reference/command-line.md", "sh"):
        for line in block.splitlines():
            invoke(line)
    assert Path("runs/first/report.html").stat().st_size > 1_000_000
    assert Path(json.loads(Path("result.json").read_text())["folder"]) == Path("runs/script")
    assert json.loads(Path("study.json").read_text())["seeds"] == [1, 2]
    assert json.loads(Path("solve.schema.json").read_text())["title"] == "mgeo solve, mgeo resume"


def test_page_has_every_json_document():
    page = (DOCS / "reference/json-documents.md").read_text(encoding="utf-8")
    page += (DOCS / "reference/file-formats.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^```{document} (\S+)$", page, re.MULTILINE)) == set(collect_documents())
