"""Files that belong together: all are of one process, or what tells that they are is not there."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from mgeo.store.atomic import lock, write_files

PATIENCE = 10.0  # seconds for another process that writes there


def write_together(contents: Mapping[Path, bytes], overwrite: bool) -> list[str]:
    """Write files, of which the last tells that the others are complete; their paths.

    Another process that writes them is waited for, and what it has made meanwhile is overwritten
    only if that is allowed.

    Raises
    ------
    OSError, ValueError
        From `check_targets` and `lock`, or if they cannot be written.
    """
    from mgeo_attitude.commands.files import check_targets

    folders: dict[Path, dict[str, bytes]] = {}
    for path, content in contents.items():
        folders.setdefault(path.parent, {})[path.name] = content
    with lock(next(iter(folders)), PATIENCE):
        check_targets(list(contents), overwrite)
        if len(folders) > 1:  # in one folder the last goes once all are on the disk
            [*contents][-1].unlink(missing_ok=True)
        for folder, files in folders.items():
            write_files(folder, files)
    return [str(path) for path in contents]
