"""Errors of the file system: unwritable folders, and a full disk at the end of a run."""

import os
from pathlib import Path

import pytest

from mgeo.store.run_folder import read_run
from tests.disk import room

SHORT = ("--evaluations", 160, "--algorithm", "mgeo-real", "--walkers", 4)


def test_unwritable_folder_is_reported_before_the_run(mgeo, monkeypatch):
    def evaluate(*arguments, **options):
        raise AssertionError("the problem was evaluated")

    monkeypatch.setattr("stand_in.Cantilever._evaluate", evaluate)
    with room(1000):
        done = mgeo("solve", "cantilever", "--out", "a")
    assert (done.exit_code, done.stderr) == (2, "Error: a: file too large\n")


@pytest.mark.parametrize("name", ["front.csv", "run.checkpoint", "front.html"])
def test_full_disk_is_one_error_and_loses_only_one_file(mgeo, monkeypatch, name):
    def fail_for_name(descriptor):
        path = Path(os.readlink(f"/proc/self/fd/{descriptor}"))
        if path.name.startswith(f".{name}"):
            raise OSError(28, "No space left on device")
        fsync(descriptor)

    fsync = os.fsync
    with monkeypatch.context() as patch:
        patch.setattr("mgeo.store.atomic.os.fsync", fail_for_name)
        done = mgeo("solve", "cantilever", *SHORT, "--out", "a")
    if name == "run.checkpoint":
        assert done.exit_code == 0
        text = " ".join(done.stdout.split())
        assert "No space left on device: 'a/run.checkpoint'" in text
    else:
        assert done.exit_code == 2
        assert done.stderr.splitlines()[-1] == f"Error: a/{name}: no space left on device"
    if name == "front.csv":
        assert "To continue after correcting the error: mgeo resume a" in done.stderr
        assert mgeo("resume", "a").exit_code == 0
    else:
        assert "knee" in done.stdout
    assert len(read_run("a").outcome.F) > 1
