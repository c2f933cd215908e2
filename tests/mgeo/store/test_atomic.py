import errno

import pytest

from mgeo.store.atomic import check_writable, write_file, write_files
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


def test_a_disk_error_leaves_the_folder_as_it_was(tmp_path, small_disk):
    write_files(tmp_path, {"a": b"old a", "b": b"old b"})
    with pytest.raises(OSError, match="too large") as caught:
        write_files(tmp_path, {"a": b"new a", "b": b"x" * (2 * LIMIT)})
    assert caught.value.errno == errno.EFBIG
    assert caught.value.filename == str(tmp_path / "b")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {
        "a": b"old a",
        "b": b"old b",
    }


@pytest.mark.parametrize("limit", [0, 1000])
def test_a_folder_without_room_is_told_before_anything_is_made(tmp_path, limit):
    check_writable(tmp_path)
    for folder in (tmp_path, tmp_path / "none" / "below"):
        with room(limit), pytest.raises(OSError, match=rf"too large: '{tmp_path}'"):
            check_writable(folder)
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_leaves_no_temporary_file(tmp_path, monkeypatch):
    def interrupt(source, target):
        raise KeyboardInterrupt

    monkeypatch.setattr("mgeo.store.atomic.os.replace", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_file(tmp_path / "a", b"content")
    assert list(tmp_path.iterdir()) == []
