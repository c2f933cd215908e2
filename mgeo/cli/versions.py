"""What is installed: the packages here, their plugins, and what they need."""

from __future__ import annotations

import platform
import re
from importlib import metadata

from mgeo.plugins.discovery import ALGORITHMS, COMMANDS, PROBLEMS, entry_points

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")


def versions() -> dict[str, str]:
    """Versions by name: of mgeo, of its plugins, of Python, and of what all of these require."""
    plugins = {
        entry.dist.name
        for group in (PROBLEMS, ALGORITHMS, COMMANDS)
        for entry in entry_points(group)
        if entry.dist
    }
    own = ["mgeo", *sorted(plugins)]
    needed = {name for package in own for name in _required(package)} - {*own}
    found = {name: metadata.version(name) for name in own}
    found["python"] = platform.python_version()
    return found | {name: metadata.version(name) for name in sorted(needed)}


def _required(package: str) -> list[str]:
    """Names of what a package cannot do without: what an extra or a platform adds is left out."""
    lines = [line for line in metadata.requires(package) or () if ";" not in line]
    return [match[0].lower() for line in lines if (match := _NAME.match(line))]
