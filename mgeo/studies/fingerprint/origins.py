"""Which code a module's name stands for: Python's, that of a distribution, or somebody's files."""

from __future__ import annotations

import sys
from functools import cache
from importlib import metadata
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec
from pathlib import Path

from mgeo.studies.fingerprint.digest import mix

_PLATFORM = ("numpy", "scipy")  # they keep what they compute; their versions are kept with runs
_NO_FILE = ("", "built-in", "frozen")
_SITES = ("site-packages", "dist-packages")


def spec_of(name: str) -> ModuleSpec | None:
    """How a module was imported, or would be; none is."""
    if name in sys.modules:
        spec: ModuleSpec | None = getattr(sys.modules[name], "__spec__", None)
        return spec
    above, _, _ = name.rpartition(".")
    try:
        if not above:
            return find_spec(name)
        parent = spec_of(above)
        if parent is None or parent.submodule_search_locations is None:
            return None
        return PathFinder.find_spec(name, parent.submodule_search_locations)
    except (ImportError, ValueError, AttributeError):
        return None


def source_file(name: str) -> Path | None:
    """The file of a module that no distribution has installed; None for all others."""
    spec = None if name == "__main__" else spec_of(name)
    if spec is None or not spec.has_location or not spec.origin or installed(name):
        return None
    return Path(spec.origin)


def installed(name: str) -> str:
    """The distribution that a module belongs to, with its version; empty if there is none."""
    top = name.partition(".")[0]
    spec = None if top == "__main__" else spec_of(top)
    if spec is None:
        return ""
    return _installed(top, spec.origin or "", tuple(spec.submodule_search_locations or ()))


@cache
def _installed(top: str, origin: str, locations: tuple[str, ...]) -> str:
    if any(part in _SITES for place in (origin, *locations) for part in Path(place).parts):
        return top if top in _PLATFORM else ", ".join(_identity(owner) for owner in _owners(top))
    # a file of such a name beside the script comes before Python's own
    own = origin in _NO_FILE or Path(origin).is_relative_to(sys.base_prefix)
    return "python" if own and top in sys.stdlib_module_names else ""


def distributions(name: str) -> dict[str, str]:
    """Name and version of the distribution that installed a module; empty for all others."""
    if installed(name) in ("", "python"):
        return {}
    return {owner.name: owner.version for owner in _owners(name.partition(".")[0])}


@cache
def _owners(top: str) -> tuple[metadata.Distribution, ...]:
    try:
        same_name = metadata.distribution(top)
    except metadata.PackageNotFoundError:
        pass
    else:
        if f"{top}/" in (same_name.read_text("RECORD") or ""):
            return (same_name,)
    # takes half a second: it reads what every distribution holds
    names = sorted(set(metadata.packages_distributions().get(top, ())))
    return tuple(metadata.distribution(name) for name in names)


def _identity(owner: metadata.Distribution) -> str:
    """A version says it all only of what came from a package index."""
    text = f"{owner.name} {owner.version}"
    if owner.read_text("direct_url.json") is None:
        return text
    lines = (owner.read_text("RECORD") or "").splitlines()
    files = sorted(line for line in lines if ".dist-info/" not in line and ",sha256=" in line)
    return f"{text} {mix(*files).hex()}"
