"""Disks that are full or cannot be written: noticed before the run, and at its end."""

import json
import os
from pathlib import Path

import pytest

from mgeo.store.run_folder import read_run
from tests.disk import room

SHORT = ("--evaluations", 160, "--algorithm", "mgeo-real", "--walkers", 4)


@pytest.fixture
def full(monkeypatch):
    """Makes the disk full for files of these names in the folder a."""

    def make(*names):
        fsync = os.fsync

        def full_for(descriptor):
            path = Path(os.readlink(f"/proc/self/fd/{descriptor}"))
            if path.parent.name == "a" and any(path.name.startswith(f".{name}") for name in names):
                raise OSError(28, "No space left on device")
            fsync(descriptor)

        monkeypatch.setattr("mgeo.store.atomic.os.fsync", full_for)

    return make


@pytest.mark.parametrize("algorithm", ["nsga2", "mgeo-real"])
def test_a_folder_that_cannot_be_written_is_told_before_the_run(mgeo, monkeypatch, algorithm):
    def evaluate(*arguments, **options):
        raise AssertionError("something was evaluated")

    from stand_in import Cantilever

    monkeypatch.setattr(Cantilever, "_evaluate", evaluate)
    with room(1000):
        done = mgeo("solve", "cantilever", "--algorithm", algorithm, "--out", "a")
    assert (done.exit_code, done.stderr) == (2, "Error: [Errno 27] File too large: 'a'\n")
    assert not Path("a").exists()


def test_without_a_first_checkpoint_there_is_no_run_and_the_one_before_stays(mgeo, full):
    mgeo("solve", "cantilever", *SHORT, "--record", "--out", "a")
    before = {path: path.read_bytes() for path in Path("a").rglob("*") if path.is_file()}
    assert "a/evaluations/record.sqlite" in map(str, before)
    full("run.checkpoint")
    done = mgeo("solve", "cantilever", *SHORT, "--overwrite", "--out", "a")
    assert done.exit_code == 2
    error = "Error: [Errno 28] No space left on device: 'a/run.checkpoint'"
    assert done.stderr.splitlines()[-1] == error
    assert {path: path.read_bytes() for path in Path("a").rglob("*") if path.is_file()} == before


def test_the_answer_is_told_though_the_page_has_no_room(mgeo):
    with room(2**20):
        done = mgeo("solve", "cantilever", *SHORT, "--out", "a")
    assert done.exit_code == 2
    error = "Error: [Errno 27] File too large: 'a/front.html'"
    assert done.stderr.splitlines()[-1] == error
    first, *_, last = done.stdout.splitlines()
    assert ", knee: " in first
    assert last == "written: a"
    assert len(read_run("a").outcome.F) > 1


def test_without_room_for_the_front_the_checkpoint_is_what_can_be_had(mgeo, full, monkeypatch):
    full("front.csv")
    done = mgeo("solve", "cantilever", *SHORT, "--out", "a", "--json")
    assert done.exit_code == 2
    told = done.stderr.splitlines()[-2:]
    assert told == [
        "To go on once that is put right: mgeo resume a",
        "Error: [Errno 28] No space left on device: 'a/front.csv'",
    ]
    document = json.loads(done.stdout)
    assert document["files"] == ["run.checkpoint"]
    assert document["answer"]["label"] == "knee"
    monkeypatch.setattr("mgeo.store.atomic.os.fsync", lambda descriptor: None)
    assert mgeo("resume", "a").exit_code == 0
    assert len(read_run("a").outcome.F) == document["solutions"]


def test_without_a_checkpoint_the_run_is_written_elsewhere(mgeo, full, tmp_path, monkeypatch):
    full("front.csv")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    done = mgeo("solve", "cantilever", "--algorithm", "nsga2", *SHORT[:2], "--out", "a")
    assert done.exit_code == 2
    assert "written: " not in done.stdout
    (place,) = tmp_path.glob("mgeo-*")
    assert done.stderr.splitlines()[-2] == f"The run was written into {place} instead"
    assert read_run(place).outcome.evaluations >= 160
    assert not Path("a").exists()


def test_only_files_of_mgeo_s_own_are_replaced(mgeo):
    mgeo("solve", "cantilever", *SHORT, "--record", "--out", "a")
    notes = Path("a/verification-notes-of-mine.json"), Path("a/evaluations/mine.txt")
    for path in notes:
        path.write_text("{}")
    assert mgeo("solve", "cantilever", *SHORT, "--overwrite", "--out", "a").exit_code == 0
    assert [path.read_text() for path in notes] == ["{}", "{}"]


def test_a_folder_that_was_there_stays(mgeo):
    Path("a").mkdir()
    with room(1000):
        assert mgeo("solve", "cantilever", *SHORT, "--out", "a").exit_code == 2
    assert list(Path("a").iterdir()) == []
