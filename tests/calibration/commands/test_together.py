"""Files that belong together: of one process, and of one writing wherever it is killed."""

import os
from threading import Thread

import pytest
from mgeo_calibration.commands.files import write_together


def test_of_two_that_write_at_once_all_files_are_those_of_one(tmp_path, monkeypatch):
    """The other begins when one file of four has its name: it waits, and overwrites all."""
    paths = [tmp_path / name for name in "abcd"]
    replace = os.replace
    other = Thread(target=write_together, args=(dict.fromkeys(paths, b"other"), True))

    def replaced(source, target):
        replace(source, target)
        if other.ident is None:
            other.start()
            other.join(0.3)

    monkeypatch.setattr(os, "replace", replaced)
    write_together(dict.fromkeys(paths, b"first"), True)
    other.join()
    assert [path.read_bytes() for path in paths] == 4 * [b"other"]
    assert sorted(tmp_path.iterdir()) == paths
    with pytest.raises(FileExistsError, match="choose another name or allow --overwrite"):
        write_together(dict.fromkeys(paths, b"third"), False)


@pytest.mark.parametrize("folder", ["", "other"])
def test_who_is_killed_leaves_no_truth_of_another_flight(tmp_path, monkeypatch, folder):
    """At no moment is there another's."""
    out, truth = tmp_path / "t.csv", tmp_path / folder / "t.json"
    truth.parent.mkdir(exist_ok=True)
    write_together({out: b"1", truth: b"1"}, False)
    replace, seen = os.replace, []

    def replaced(source, target):
        replace(source, target)
        seen.append([path.read_bytes() if path.exists() else None for path in (out, truth)])

    monkeypatch.setattr(os, "replace", replaced)
    write_together({out: b"2", truth: b"2"}, True)
    assert seen == [[b"2", None], [b"2", b"2"]]
