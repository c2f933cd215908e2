"""The command as a process of its own: pipes, signals, start-up."""

import os
import re
import signal
import subprocess
import sys
from contextlib import contextmanager
from functools import partial

import numpy as np
import pytest

from mgeo.runs.prepare import PreparedRun
from mgeo.store.run_folder import read_run

COMMAND = [sys.executable, "-m", "mgeo"]
LONG = ["--evaluations", "10000000", "--algorithm", "mgeo-real", "--runs", "4", "--sigma", "0.05"]


@contextmanager
def started(arguments, environment, folder):
    with subprocess.Popen(
        [*COMMAND, *arguments],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),  # ignored under nohup
    ) as process:
        try:
            yield process
        finally:
            process.kill()  # does nothing to one that has ended


def wait_for_progress(process):
    for line in process.stderr:
        if re.search(r"\d of [\d,]+ evaluations", line):  # the first line says what is to be done
            return
    raise RuntimeError(f"the run ended early: {process.stdout.read()}")


BLAS = """
import atexit, os, sys
from mgeo.cli.app import main
assert "numpy" not in sys.modules
atexit.register(lambda: print(os.environ["OPENBLAS_NUM_THREADS"]))
sys.argv = ["mgeo", "--no-color", "schema", "study"]
main()
"""


def test_blas_has_one_thread_however_many_processors_there_are():
    """It adds in another order in several: a seed's front and a study's tables would differ."""
    environment = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
    for given, expected in (({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, "3")):
        done = subprocess.run(
            [sys.executable, "-c", BLAS],
            env=environment | given,
            capture_output=True,
            text=True,
            check=True,
            timeout=100,
        )
        assert done.stdout.splitlines()[-1] == expected


@pytest.mark.parametrize(
    ("number", "code"),
    [
        pytest.param(signal.SIGINT, 130, id="ctrl-c"),
        pytest.param(signal.SIGTERM, 143, id="sigterm", marks=pytest.mark.slow),
    ],
)
def test_a_signal_ends_the_run_and_keeps_what_was_found(
    number, code, stand_in, stand_in_environment, tmp_path
):
    arguments = ["solve", "slow-cantilever", *LONG, "--out", "a"]
    with started(arguments, stand_in_environment, tmp_path) as process:
        wait_for_progress(process)
        process.send_signal(number)
        output, errors = process.communicate(timeout=300)
    assert process.returncode == code, errors
    assert "interrupted after" in output
    run = read_run(tmp_path / "a")
    assert run.outcome.stop_reason == "signal"
    assert 0 < run.outcome.evaluations < 10_000_000
    assert (tmp_path / "a" / "front.html").stat().st_size > 1_000_000
    problem = PreparedRun.of(run.configuration).problem
    assert np.array_equal(problem.evaluate(run.outcome.X), run.outcome.F)


@pytest.mark.slow
def test_a_pipe_gets_no_control_characters(stand_in_environment, tmp_path):
    environment = {**stand_in_environment, "FORCE_COLOR": "1", "TERM": "xterm-256color"}
    arguments = ["solve", "cantilever", *LONG, "--evaluations", "400"]
    with started(arguments, environment, tmp_path) as process:
        output, errors = process.communicate(timeout=300)
    assert process.returncode == 0, errors
    for text in (output, errors):
        assert text
        assert all(character.isprintable() or character == "\n" for character in text)
    assert "100%  400 of 400 evaluations" in errors
