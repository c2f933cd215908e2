"""What a run was made with, which its result may depend on in the last digits."""

from __future__ import annotations

import platform
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from typing import Any

from mgeo.benchmarks.collections import COCO
from mgeo.plugins.discovery import plugin_versions
from mgeo.studies.fingerprint.modules import distributions

_ALWAYS = ("mgeo", "pymoo", "numpy", "scipy", "moocore")


def made_with(*parts: Any) -> dict[str, str]:
    """Versions here: of Python, the packages always used, and those that a problem is from."""
    found = {"python": platform.python_version()}
    found |= {name: version(name) for name in _ALWAYS}
    modules = {cls.__module__ for part in parts for cls in type(part).__mro__}
    for module in sorted(modules):
        found |= distributions(module)
    if "mgeo.benchmarks.coco" in modules:
        found[COCO] = version(COCO)
    return found | plugin_versions(modules)


def distinct(versions: Iterable[Mapping[str, str]]) -> dict[str, str | list[str]]:
    """Of several runs: a package's version, or a list of them where the runs differ."""
    seen: dict[str, set[str]] = {}
    for run in versions:
        for name, value in run.items():
            seen.setdefault(name, set()).add(value)
    return {name: sorted(v) if len(v) > 1 else v.pop() for name, v in seen.items()}
