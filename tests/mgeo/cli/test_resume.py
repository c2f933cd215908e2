"""`mgeo resume`: after a kill, after Ctrl-C, and to make a run longer."""

import json
import os
import re
import signal
import time
from pathlib import Path
from pkgutil import resolve_name

import numpy as np
import pytest

from mgeo import read_record
from mgeo.store.atomic import lock_folder
from mgeo.store.checkpoint import read_checkpoint_metadata
from mgeo.store.run_folder import CHECKPOINT_FILE, read_run

from .test_process import started

# 8 evaluations a generation
SHORT = ["--algorithm", "mgeo-real", "--walkers", "4", "--set", "sigma=0.05"]


def solve(mgeo, folder, evaluations, *more):
    done = mgeo("solve", "cantilever", *SHORT, "--evaluations", evaluations, "--out", folder, *more)
    assert done.exit_code == 0, done.output
    return read_run(folder)


def same(a, b):
    one, two = a.outcome, b.outcome
    return (
        a.configuration == b.configuration
        and np.array_equal(one.X, two.X)
        and np.array_equal(one.F, two.F)
        and one.hypervolume == two.hypervolume
        and (one.stop_reason, one.n_evaluations) == (two.stop_reason, two.n_evaluations)
        and one.failures == two.failures
    )


def test_a_finished_run_is_made_longer(mgeo):
    first = solve(mgeo, "a", 160)
    expected = solve(mgeo, "b", 400)
    before = read_checkpoint_metadata(Path("a") / CHECKPOINT_FILE)["wall_time_s"]
    done = mgeo("resume", "a", "--evaluations", 400)
    assert done.exit_code == 0, done.output
    assert "finished after 400 evaluations" in done.stdout
    assert "100%  400 of 400 evaluations" in done.stderr
    longer = read_run("a")
    assert same(longer, expected)
    assert longer.outcome.start_time == first.outcome.start_time
    # of the first part up to its last checkpoint: what came after may take longer than the rest
    assert longer.outcome.wall_time_s > before > 0.0
    assert Path("a/front.html").exists()


def test_a_plugin_that_computes_something_else_is_refused(mgeo, monkeypatch):
    solve(mgeo, "a", 160)
    before = Path("a/front.csv").read_bytes()
    monkeypatch.setattr("stand_in.DENSITY", 7850.0)
    done = mgeo("resume", "a", "--evaluations", 320)
    assert done.exit_code == 2
    told = r"Error: a/run.checkpoint belongs to another problem: at x = .* F\[0\] = \S+, expected"
    assert re.match(told, done.stderr)
    assert Path("a/front.csv").read_bytes() == before
    assert mgeo("resume", "a", "--evaluations", 320, "--no-check").exit_code == 0


def test_every_evaluation_is_recorded_on_demand(mgeo):
    solve(mgeo, "a", 160, "--record")
    assert len(read_record("a/evaluations")) == 160
    assert mgeo("resume", "a", "--evaluations", 320, "-q").output == ""
    table = read_record("a/evaluations")
    solve(mgeo, "b", 320, "--record")
    assert table.equals(read_record("b/evaluations"))
    refused = mgeo("solve", "zdt1", "--algorithm", "moead", "--record", "--out", "d")
    assert refused.exit_code == 2
    assert "evaluations of 'moead' cannot be recorded" in refused.stderr
    assert not Path("d").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none"], "none cannot be resumed: there is no run.checkpoint in it"),
        (["a", "--evaluations", "24"], "the new budget is 24 evaluations: expected at least the 1"),
        (["cut"], "run.checkpoint: not a checkpoint, or a damaged one"),
    ],
)
def test_bad_input_is_one_line_and_changes_nothing(mgeo, arguments, message):
    solve(mgeo, "a", 160)
    Path("cut").mkdir()
    Path("cut", CHECKPOINT_FILE).write_bytes(Path("a", CHECKPOINT_FILE).read_bytes()[:-1])
    before = {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()}
    refused = mgeo("resume", *arguments)
    assert refused.exit_code == 2
    assert re.match(rf"Error: .*{message}", refused.stderr), refused.stderr
    assert refused.stderr.count("\n") == 1
    assert {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()} == before


def test_a_folder_that_somebody_works_in_is_left_alone(mgeo):
    solve(mgeo, "a", 160)
    before = {path: path.read_bytes() for path in Path("a").iterdir()}
    with lock_folder(Path("a")):
        for command in (["resume", "a"], ["solve", "cantilever", "--overwrite", "--out", "a"]):
            refused = mgeo(*command)
            assert (refused.exit_code, refused.stdout) == (2, "")
            assert refused.stderr == "Error: a is in use: another process is running there\n"
    assert {path: path.read_bytes() for path in Path("a").iterdir()} == before


def wait_for(path, process):
    while not path.exists():
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)


def test_a_run_goes_on_after_a_kill_and_after_ctrl_c(
    mgeo, stand_in_environment, tmp_path, monkeypatch
):
    arguments = ["solve", "slow-cantilever", *SHORT, "--evaluations", "240", "--record"]
    arguments += ["--out", "a"]
    slow = stand_in_environment | {"STAND_IN_SECONDS": "0.5"}  # 15 in all: it cannot end meanwhile
    with started(arguments, slow, tmp_path) as process:
        wait_for(tmp_path / "a" / CHECKPOINT_FILE, process)
        refused = mgeo("resume", "a")
        assert (refused.exit_code, refused.stderr) == (
            2, "Error: a is in use: another process is running there\n",
        )  # fmt: skip
        process.kill()
    assert not Path("a/run.json").exists()
    refused = mgeo(*arguments)
    assert refused.exit_code == 2
    assert "or continue its run by mgeo resume a" in refused.stderr

    evaluate = resolve_name("stand_in:Cantilever._evaluate")
    batches = []

    def interrupted(self, X, out, *args, **kwargs):
        evaluate(self, X, out)
        batches.append(len(X))
        if len(batches) == 10:
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr("stand_in.SlowCantilever._evaluate", interrupted)
    stopped = mgeo("resume", "a")
    assert stopped.exit_code == 130, stopped.output
    assert "interrupted after" in stopped.stdout
    assert stopped.stdout.splitlines()[-1] == "to continue: mgeo resume a"
    assert 0 < json.loads(Path("a/run.json").read_text())["n_evaluations"] < 240
    done = mgeo("resume", "a")
    assert done.exit_code == 0, done.output
    solve(mgeo, "b", 240, "--record")
    one, two = read_run("a").outcome, read_run("b").outcome
    assert np.array_equal(one.X, two.X)
    assert np.array_equal(one.F, two.F)
    assert read_record("a/evaluations").equals(read_record("b/evaluations"))
