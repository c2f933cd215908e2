"""Which code a module's name stands for: a distribution's version, or files under development."""

from __future__ import annotations

import ast
import hashlib
import platform
import sys
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib import metadata
from importlib.machinery import EXTENSION_SUFFIXES, ModuleSpec, PathFinder
from importlib.metadata import version
from importlib.util import find_spec, resolve_name
from pathlib import Path
from typing import Any

from mgeo.benchmarks.collections import COCO
from mgeo.plugins.discovery import plugin_versions

_PLATFORM = ("numpy", "scipy")  # they keep what they compute; their versions are kept with runs
_SITES = ("site-packages", "dist-packages")
_STUB = ".pyi"  # by which a package may load names when they are first asked for
_CODE = (".py", _STUB, *EXTENSION_SUFFIXES)


class UncertainError(ValueError):
    """Something that may compute other values the next time; the message says what it is."""


def installed(name: str) -> str:
    """The distribution that a module belongs to, with its version; empty if there is none."""
    top = name.partition(".")[0]
    spec = _spec(top)
    if spec is None:
        return ""
    return _installed(top, spec.origin or "", tuple(spec.submodule_search_locations or ()))


def distributions(name: str) -> dict[str, str]:
    """Name and version of the distribution that installed a module; empty for all others."""
    if installed(name) in ("", "python"):
        return {}
    return dict(_versions(name.partition(".")[0]))


@cache
def _versions(top: str) -> Mapping[str, str]:
    # asked for with every run, and read from a file each time
    return {owner.name: owner.version for owner in _owners(top)}


def source_file(name: str) -> Path | None:
    """The file of a module that no distribution has installed; None for all others."""
    spec = _spec(name)
    if spec is None or not spec.has_location or not spec.origin or installed(name):
        return None
    return Path(spec.origin)


def code_of(name: str) -> str:
    """What `installed` says, or a digest of all files that a module under development may run.

    These are every file of code in its folder if it belongs to a package, and the same for each
    module that it imports, anywhere in its text or its stub's, and that these import. The packages
    above it count where they are imported by name. Of a script or a notebook nothing is said.

    Raises
    ------
    UncertainError
        If one of the files was changed after they were first looked at, so that nobody knows
        which of its versions Python has read.
    """
    if source_file(name) is None:
        return installed(name)
    digest, files = _closure(name)
    for path in files:
        if _stamp(path) != _read(path)[1]:
            raise UncertainError(f"{path} was changed meanwhile: start Python anew")
    return digest


def imported(module: str, names: Iterable[str], level: int, package: str) -> Iterator[str]:
    """The modules that ``from module import names`` in a package stands for."""
    try:
        base = resolve_name("." * level + module, package or None)
    except ImportError:  # beyond the topmost package
        return
    for below in [f"{base}.{name}" for name in names] or [base]:
        yield below if not installed(base) and _spec(below) is not None else base


def _spec(name: str) -> ModuleSpec | None:
    """How a module was imported, or would be; none is."""
    if name == "__main__":
        return None
    if name in sys.modules:
        spec: ModuleSpec | None = getattr(sys.modules[name], "__spec__", None)
        return spec
    above, _, _ = name.rpartition(".")
    try:
        if not above:
            return find_spec(name)
        parent = _spec(above)
        if parent is None or parent.submodule_search_locations is None:
            return None
        return PathFinder.find_spec(name, parent.submodule_search_locations)
    except (ImportError, ValueError, AttributeError):
        return None


@cache
def _installed(top: str, origin: str, locations: tuple[str, ...]) -> str:
    if any(part in _SITES for place in (origin, *locations) for part in Path(place).parts):
        return top if top in _PLATFORM else ", ".join(_identity(owner) for owner in _owners(top))
    # a file of such a name beside the script comes before Python's own
    own = origin in ("", "built-in", "frozen") or Path(origin).is_relative_to(sys.base_prefix)
    return "python" if own and top in sys.stdlib_module_names else ""


def _owners(top: str) -> list[metadata.Distribution]:
    return [metadata.distribution(name) for name in sorted(set(_providers().get(top, ())))]


@cache
def _providers() -> Mapping[str, list[str]]:
    return metadata.packages_distributions()  # reads what every distribution holds


def _identity(owner: metadata.Distribution) -> str:
    """A version says it all only of what came from a package index."""
    text = f"{owner.name} {owner.version}"
    if owner.read_text("direct_url.json") is None:
        return text
    lines = (owner.read_text("RECORD") or "").splitlines()
    files = sorted(line for line in lines if ".dist-info/" not in line and ",sha256=" in line)
    return f"{text} {_digest(files)}"


@cache
def _closure(module: str) -> tuple[str, set[Path]]:
    waiting, seen = [module], {module}
    found: set[str] = set()
    files: set[Path] = set()
    while waiting:
        name = waiting.pop()
        own = source_file(name)
        if own is None:
            found.add(installed(name))
            continue
        spec = _spec(name)
        package = (spec and spec.parent) or ""
        folder = [path for path in own.parent.iterdir() if path.name.endswith(_CODE)]
        for path in folder if package else [own]:
            found.add(f"{package}/{path.name} {hashlib.sha256(_read(path)[0]).hexdigest()}")
            files.add(path)
        stub = own.with_suffix(_STUB)
        new = {
            each for path in (own, stub) if path in files for each in _imports(path, package)
        } - seen
        seen |= new
        waiting += new
    return _digest(sorted(found)), files


@cache
def _read(path: Path) -> tuple[bytes, tuple[int, int]]:
    stamp = _stamp(path)
    return path.read_bytes(), stamp


def _digest(lines: Iterable[str]) -> str:
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


def _stamp(path: Path) -> tuple[int, int]:
    try:
        status = path.stat()
    except FileNotFoundError:
        return 0, 0
    return status.st_mtime_ns, status.st_size


@cache
def _imports(path: Path, package: str) -> tuple[str, ...]:
    """Names of modules that a file may import."""
    if path.suffix not in (".py", _STUB):
        return ()
    try:
        nodes = list(ast.walk(ast.parse(_read(path)[0])))
    except (SyntaxError, ValueError):  # so it cannot be imported
        return ()
    plain = [alias.name for n in nodes if isinstance(n, ast.Import) for alias in n.names]
    members = [
        name
        for n in nodes
        if isinstance(n, ast.ImportFrom)
        for name in imported(n.module or "", [a.name for a in n.names], n.level, package)
    ]
    return (*plain, *members)


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
