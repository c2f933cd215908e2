import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

try:
    import fcntl
except ImportError:
    fcntl = None

from mgeo.store.atomic import LOCK_FILE, lock

HOLD = "import sys, time\nfrom pathlib import Path\nfrom mgeo.store.atomic import lock\n" + (
    "with lock(Path(sys.argv[1])): print('in', flush=True); time.sleep(60)"
)


def test_one_process_a_folder_and_nothing_is_left(tmp_path):
    with lock(tmp_path), pytest.raises(ValueError, match="is in use"), lock(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []
    with lock(tmp_path):
        assert [path.name for path in tmp_path.iterdir()] == [LOCK_FILE]


def test_what_a_killed_process_leaves_keeps_nobody_out(tmp_path):
    with subprocess.Popen([sys.executable, "-c", HOLD, tmp_path], stdout=subprocess.PIPE) as other:
        assert other.stdout.readline() == b"in\n"
        with pytest.raises(ValueError, match="is in use"), lock(tmp_path):
            pass
        other.kill()
    assert (tmp_path / LOCK_FILE).exists()
    with lock(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(fcntl is None, reason="POSIX")
def test_a_file_system_that_locks_only_what_is_open_for_writing(tmp_path, monkeypatch):
    """NFS, for which Linux makes locks of byte ranges."""
    flock = fcntl.flock

    def of_nfs(descriptor, operation):
        if fcntl.fcntl(descriptor, fcntl.F_GETFL) & os.O_ACCMODE == os.O_RDONLY:
            raise OSError(errno.EBADF, "Bad file descriptor")
        flock(descriptor, operation)

    monkeypatch.setattr(fcntl, "flock", of_nfs)
    with lock(tmp_path):
        pass


def test_one_that_is_removed_while_somebody_waits_to_open_it_is_no_lock(tmp_path, monkeypatch):
    """Who comes as another one leaves may lock a file that is no longer there."""
    real, opened = os.open, []

    def slow(path, *arguments):
        found = real(path, *arguments)
        if not opened:
            os.unlink(path)
        opened.append(path)
        return found

    monkeypatch.setattr("os.open", slow)
    with lock(tmp_path), pytest.raises(ValueError, match="is in use"), lock(tmp_path):
        pass
    assert len(opened) == 3


def test_a_link_in_its_place_is_not_followed(tmp_path):
    (tmp_path / LOCK_FILE).symlink_to(tmp_path / "elsewhere")
    with pytest.raises(OSError, match="symbolic link"), lock(tmp_path):
        pass
    assert not (tmp_path / "elsewhere").exists()


def test_where_nothing_that_is_open_can_be_removed(tmp_path, monkeypatch):
    """Windows."""
    real, opened = Path.unlink, set()
    opening, closing = os.open, os.close

    def open_it(*arguments):
        opened.add(descriptor := opening(*arguments))
        return descriptor

    def close(descriptor):
        opened.discard(descriptor)
        closing(descriptor)

    def unlink(path):
        if opened:
            raise PermissionError(13, "used by another process", str(path))
        real(path)

    monkeypatch.setattr("os.open", open_it)
    monkeypatch.setattr("os.close", close)
    monkeypatch.setattr("pathlib.Path.unlink", unlink)
    with lock(tmp_path):
        assert opened
    assert list(tmp_path.iterdir()) == []
