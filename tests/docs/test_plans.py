"""The commands and the code of docs/how-to/export-plans.md write the same plan."""

from pathlib import Path

import pytest
from mgeo_attitude.plan import read_json

from .pages import blocks, run


@pytest.mark.slow
def test_commands_and_python(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for line in blocks("how-to/export-plans.md", "sh")[0].splitlines():
        short = ["--evaluations", "1080", "--quiet"] if "solve" in line else []
        run(line, *short)
    by_commands = read_json("plan.json"), Path("plan.csv").read_bytes()
    (code,) = blocks("how-to/export-plans.md", "python")
    exec(code, {})
    assert (read_json("plan.json"), Path("plan.csv").read_bytes()) == by_commands
    assert "ORIGINATOR = INPE\n" in Path("plan.aem").read_text(encoding="utf-8")
