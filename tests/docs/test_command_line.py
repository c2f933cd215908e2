"""The commands of docs/reference/command-line.md, and the keys of their JSON documents."""

import json
import re
from pathlib import Path

import pytest

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


def documented(command):
    """Return the keys in the row of a command."""
    page = (DOCS / "reference/command-line.md").read_text(encoding="utf-8")
    (row,) = re.findall(rf"^\| .*`{command}`[^|]*\| (.*) \|$", page, re.MULTILINE)
    return set(re.findall(r"`(\w+)`", row))


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
    result = json.loads(Path("result.json").read_text())
    assert set(result) | set(result["recommended"]) == documented("solve")
    assert set(json.loads(Path("study.json").read_text())) <= documented("study")
    for line, command in (
        ("mgeo solve attitude --evaluations 1080 --dry-run --json", "solve --dry-run"),
        ("mgeo study study.toml --dry-run --json --seeds 1", "study --dry-run"),
        ("mgeo report runs/script --json", "report"),
    ):
        assert set(json.loads(invoke(line))) == documented(command)
