"""Compiled code is kept where nobody else can put any."""

import os

import pytest
from mgeo_attitude.filter.kernel import check_private

pytestmark = pytest.mark.skipif(not hasattr(os, "getuid"), reason="POSIX permissions")


@pytest.fixture
def folder(tmp_path):
    """A folder of one's own, in a folder of one's own."""
    made = tmp_path / "above" / "kernels"
    made.mkdir(mode=0o700, parents=True)
    made.parent.chmod(0o700)
    return made


def test_a_folder_of_ones_own_is_trusted(folder):
    check_private(folder)
    (folder / "__pycache__").mkdir(mode=0o755)
    check_private(folder)


@pytest.mark.parametrize("mode", [0o770, 0o707, 0o777, 0o1777])
def test_a_folder_that_others_write_to_is_not(folder, mode):
    folder.chmod(mode)
    with pytest.raises(PermissionError, match="kernels belongs to, or can be written by"):
        check_private(folder)


@pytest.mark.parametrize("mode", [0o707, 0o777])
def test_nor_one_that_others_could_replace(folder, mode):
    folder.parent.chmod(mode)
    with pytest.raises(PermissionError, match="above belongs to"):
        check_private(folder)
    folder.parent.chmod(mode | 0o1000)  # where nobody renames what is another's, as in /tmp
    check_private(folder)


def test_nor_where_the_group_may_replace_it(folder, monkeypatch):
    folder.parent.chmod(0o770)
    check_private(folder)  # the user's own group
    monkeypatch.setattr(os, "getgid", lambda: os.stat(folder.parent).st_gid + 1)
    with pytest.raises(PermissionError, match="above belongs to"):
        check_private(folder)


def test_nor_one_of_somebody_else(folder, monkeypatch):
    owner = os.stat(folder).st_uid
    monkeypatch.setattr(os, "getuid", lambda: owner + 1)
    with pytest.raises(PermissionError, match="kernels belongs to"):
        check_private(folder)


def test_nor_machine_code_of_somebody_else(folder, tmp_path):
    (tmp_path / "other").mkdir(mode=0o700)
    (folder / "__pycache__").symlink_to(tmp_path / "other")
    with pytest.raises(PermissionError, match="__pycache__ belongs to"):
        check_private(folder)
    (folder / "__pycache__").unlink()
    (folder / "__pycache__").mkdir()
    (folder / "__pycache__").chmod(0o777)
    with pytest.raises(PermissionError, match="__pycache__ belongs to"):
        check_private(folder)


def test_a_link_is_judged_by_where_it_leads(folder, tmp_path):
    link = tmp_path / "link"
    link.symlink_to(folder)
    check_private(link)
    folder.parent.chmod(0o777)
    with pytest.raises(PermissionError, match="above belongs to"):
        check_private(link)
