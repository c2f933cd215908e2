import errno

import pytest

from mgeo.store.atomic import write_file, write_files
from tests.disk import room

LIMIT = 1 << 20


@pytest.fixture
def small_disk():
    with room(LIMIT):
        yield


def test_files_are_written_and_replaced(tmp_path):
    write_file(tmp_path / "a", b"old")
    write_files(tmp_path, {"a": b"new", "b": "é\n".encode()})
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {
        "a": b"new",
        "b": b"\xc3\xa9\n",
    }


def test_disk_error_leaves_folder_unchanged(tmp_path, small_disk):
    write_files(tmp_path, {"a": b"old a", "b": b"old b"})
    with pytest.raises(OSError, match="too large") as caught:
        write_files(tmp_path, {"a": b"new a", "b": b"x" * (2 * LIMIT)})
    assert caught.value.errno == errno.EFBIG
    assert caught.value.filename == str(tmp_path / "b")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {
        "a": b"old a",
        "b": b"old b",
    }


def test_link_with_name_of_temporary_file_is_not_followed(tmp_path, monkeypatch):
    target = tmp_path / "precious"
    target.write_text("old")
    monkeypatch.setattr("secrets.token_hex", lambda n: "0" * 2 * n)
    (tmp_path / f".a.{'0' * 16}.tmp").symlink_to(target)
    with pytest.raises(FileExistsError):
        write_file(tmp_path / "a", b"new")
    assert target.read_text() == "old"
