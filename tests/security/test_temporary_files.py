"""Names that somebody has put a link at before we write there."""

import os

import pytest

from mgeo.store.atomic import write_file


def write(path):
    write_file(path, b"new")


def test_a_link_at_a_guessed_name_is_not_written_through(tmp_path, monkeypatch):
    precious = tmp_path / "precious"
    precious.write_text("old")
    monkeypatch.setattr("mgeo.store.atomic.secrets.token_hex", lambda n: "0" * 2 * n)
    write(tmp_path / "a")
    used = []
    monkeypatch.setattr(os, "replace", lambda source, target: used.append(source))
    write(tmp_path / "a")
    guessed = tmp_path / os.path.basename(used[0])
    guessed.unlink(missing_ok=True)
    guessed.symlink_to(precious)
    with pytest.raises(FileExistsError):
        write(tmp_path / "a")
    assert precious.read_text() == "old"
