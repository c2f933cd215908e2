"""Command ``mgeo resume``: extended runs, and runs after a kill or Ctrl-C."""

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

from .test_process import start

# A generation has 8 evaluations.
SHORT = ["--algorithm", "mgeo-real", "--walkers", "4", "--set", "sigma=0.05"]


def solve(mgeo, folder, evaluations, *more):
    done = mgeo("solve", "cantilever", *SHORT, "--evaluations", evaluations, "--out", folder, *more)
    assert done.exit_code == 0, done.output
    return read_run(folder)


def are_equal(a, b):
    first, second = a.outcome, b.outcome
    return (
        a.configuration == b.configuration
        and np.array_equal(first.X, second.X)
        and np.array_equal(first.F, second.F)
        and first.hypervolume == second.hypervolume
        and (first.stop_reason, first.n_evaluations) == (second.stop_reason, second.n_evaluations)
        and first.failures == second.failures
    )


def test_extended_run_equals_longer_run(mgeo):
    first = solve(mgeo, "a", 160)
    expected = solve(mgeo, "b", 400)
    before = read_checkpoint_metadata(Path("a") / CHECKPOINT_FILE)["wall_time_s"]
    done = mgeo("resume", "a", "--evaluations", 400)
    assert done.exit_code == 0, done.output
    assert "400 evaluations" in done.stdout
    assert "400 of 400 evaluations" in done.stderr
    longer = read_run("a")
    assert are_equal(longer, expected)
    assert longer.outcome.start_time == first.outcome.start_time
    # Only the time up to the last checkpoint is known to be included.
    assert longer.outcome.wall_time_s > before > 0.0
    assert Path("a/front.html").exists()


def test_resume_refuses_a_problem_with_other_values(mgeo, monkeypatch):
    solve(mgeo, "a", 160)
    before = Path("a/front.csv").read_bytes()
    monkeypatch.setattr("stand_in.DENSITY", 7850.0)
    done = mgeo("resume", "a", "--evaluations", 320)
    assert done.exit_code == 2
    message = (
        r"Error: a/run.checkpoint belongs to another problem: at x = .* F\[0\] = \S+, expected"
    )
    assert re.match(message, done.stderr)
    assert Path("a/front.csv").read_bytes() == before
    assert mgeo("resume", "a", "--evaluations", 320, "--no-check").exit_code == 0


def test_record_of_resumed_run_equals_uninterrupted_run(mgeo):
    solve(mgeo, "a", 160, "--record")
    assert len(read_record("a/evaluations")) == 160
    assert mgeo("resume", "a", "--evaluations", 320, "-q").output == ""
    table = read_record("a/evaluations")
    solve(mgeo, "b", 320, "--record")
    assert table.equals(read_record("b/evaluations"))
    result = mgeo("solve", "zdt1", "--algorithm", "moead", "--record", "--out", "d")
    assert result.exit_code == 2
    assert "evaluations of 'moead' cannot be recorded" in result.stderr
    assert not Path("d").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none"], "none cannot be resumed: there is no run.checkpoint"),
        (
            ["a", "--evaluations", "24"],
            "the new budget is 24 evaluations: expected at least 160, the number of evaluations",
        ),
        (["cut"], "run.checkpoint: not a checkpoint, or a damaged one"),
    ],
)
def test_invalid_input_is_one_line_and_changes_no_file(mgeo, arguments, message):
    solve(mgeo, "a", 160)
    Path("cut").mkdir()
    Path("cut", CHECKPOINT_FILE).write_bytes(Path("a", CHECKPOINT_FILE).read_bytes()[:-1])
    before = {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()}
    result = mgeo("resume", *arguments)
    assert result.exit_code == 2
    assert re.match(rf"Error: .*{message}", result.stderr), result.stderr
    assert result.stderr.count("\n") == 1
    assert {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()} == before


def test_folder_of_another_process_is_left_unchanged(mgeo):
    solve(mgeo, "a", 160)
    before = {path: path.read_bytes() for path in Path("a").iterdir()}
    with lock_folder(Path("a")):
        for command in (["resume", "a"], ["solve", "cantilever", "--overwrite", "--out", "a"]):
            result = mgeo(*command)
            assert (result.exit_code, result.stdout) == (2, "")
            assert result.stderr == "Error: a is in use: another process is running there\n"
    assert {path: path.read_bytes() for path in Path("a").iterdir()} == before


def wait_for(path, process):
    while not path.exists():
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)


def test_run_after_a_kill_and_ctrl_c_equals_uninterrupted_run(
    mgeo, stand_in_environment, tmp_path, monkeypatch
):
    arguments = ["solve", "slow-cantilever", *SHORT, "--evaluations", "240", "--record"]
    arguments += ["--out", "a"]
    # The run takes 15 s in total, so that it cannot end before it is stopped.
    slow = stand_in_environment | {"STAND_IN_SECONDS": "0.5"}
    with start(arguments, slow, tmp_path) as process:
        wait_for(tmp_path / "a" / CHECKPOINT_FILE, process)
        result = mgeo("resume", "a")
        assert (result.exit_code, result.stderr) == (
            2, "Error: a is in use: another process is running there\n",
        )  # fmt: skip
        process.kill()
    assert not Path("a/run.json").exists()
    result = mgeo(*arguments)
    assert result.exit_code == 2
    assert "or continue its run with mgeo resume a" in result.stderr

    evaluate = resolve_name("stand_in:Cantilever._evaluate")
    batches = []

    def evaluate_and_interrupt(self, X, out, *args, **kwargs):
        evaluate(self, X, out)
        batches.append(len(X))
        if len(batches) == 10:
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr("stand_in.SlowCantilever._evaluate", evaluate_and_interrupt)
    stopped = mgeo("resume", "a")
    assert stopped.exit_code == 130, stopped.output
    assert "interrupted after" in stopped.stdout.lower()
    assert stopped.stdout.splitlines()[-1].endswith("mgeo resume a")
    assert 0 < json.loads(Path("a/run.json").read_text())["n_evaluations"] < 240
    done = mgeo("resume", "a")
    assert done.exit_code == 0, done.output
    solve(mgeo, "b", 240, "--record")
    resumed, uninterrupted = read_run("a").outcome, read_run("b").outcome
    assert np.array_equal(resumed.X, uninterrupted.X)
    assert np.array_equal(resumed.F, uninterrupted.F)
    assert read_record("a/evaluations").equals(read_record("b/evaluations"))
