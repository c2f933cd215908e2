"""Digest of the code, data and package versions on which executed pages depend."""

import hashlib
import os
import platform
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path

#: Files and folders that are hashed, relative to the root of the repository.
SOURCES = (
    "mgeo",
    "problems",
    "docs/fronts",
    "docs/scenarios",
    "docs/robust.jsonl",
    "docs/convergence_rules.jsonl",
    "docs/studies",
    "docs/validation",
    "docs/_extensions",
)
_KINDS = {".py", ".pyi", ".toml", ".csv", ".json", ".jsonl", ".html", ".js", ".css", ".npz"}
_PACKAGES = (
    *("numpy", "pandas", "plotly", "pymoo", "moocore", "numba", "scipy", "myst-nb"),
    *("ppigrf", "pyerfa", "sgp4"),  # field, Sun and orbits
)


def compute_digest(root: Path, sources: Iterable[str] = SOURCES) -> str:
    """Return a digest that changes if the output of an executed page may change."""
    state = hashlib.sha256()
    state.update(platform.python_version().encode())
    state.update(b"small" if "MGEO_NOTEBOOK_SMALL" in os.environ else b"")
    for package in _PACKAGES:
        state.update(f"{package} {version(package)}\n".encode())
    for source in sources:
        for path in sorted([root / source, *(root / source).rglob("*")]):
            if path.suffix in _KINDS and path.is_file() and "__pycache__" not in path.parts:
                state.update(f"{path.relative_to(root)}\n".encode())
                state.update(hashlib.sha256(path.read_bytes()).digest())
    return state.hexdigest()[:16]
