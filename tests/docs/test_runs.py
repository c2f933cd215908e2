"""The code and the commands of docs/how-to/long-runs.md."""

import pytest

from mgeo import read_record
from mgeo.store.run_folder import read_run

from .pages import blocks, run


def test_python(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "runs"}
    for code in blocks("how-to/long-runs.md", "python"):
        exec(code, names)
    assert len(names["best"]) == 20
    assert 0 < names["evaluator"].n_failed < 1000


@pytest.mark.slow
def test_commands(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (commands,) = blocks("how-to/long-runs.md", "sh")
    outcomes = []
    for command in commands.splitlines():
        run(command)
        outcomes.append(read_run("runs/long").outcome)
    assert [outcome.n_evaluations for outcome in outcomes] == [1056, 1056, 2112]
    assert outcomes[0].F.tolist() == outcomes[1].F.tolist()
    assert len(read_record("runs/long/evaluations")) == 2112
