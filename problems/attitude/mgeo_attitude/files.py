"""Files that are written whole or not at all, as by `mgeo.store.atomic`.

A problem does without mgeo.
"""

from __future__ import annotations

import os
import secrets
from pathlib import Path


def write_text(path: Path, text: str) -> None:
    """Write a file in UTF-8; a reader sees the old content or the new one, never a part."""
    if path.exists() and not path.is_file():  # the name of a device must not be taken over
        raise FileExistsError(f"{path} is a folder, a pipe or a device: expected a file")
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(8)}.tmp")
    try:
        with open(temporary, "x", encoding="utf-8", newline="\n") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
