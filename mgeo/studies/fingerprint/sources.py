"""The files of packages under development: what a module runs is in its own and what it imports."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.util import resolve_name
from pathlib import Path

from mgeo.studies.fingerprint.origins import installed, source_file, spec_of
from mgeo.studies.fingerprint.uncertain import UncertainError

_CODE = (".py", *EXTENSION_SUFFIXES)


def sources(module: str) -> bytes:
    """Digest of all code that a module may run; empty for one of an installed distribution.

    That is every file of code in its folder if it belongs to a package, and the same for each
    module that it imports, anywhere in its text, and that these import. The packages above it
    count where they are imported by name.

    Raises
    ------
    UncertainError
        If one of the files was changed after they were first looked at, so that nobody knows
        which of its versions Python has read.
    """
    closure = _closure(module)
    for path, stamp in closure.files.items():
        if _stamp(path) != stamp:
            raise UncertainError(f"{path} was changed meanwhile: start Python anew")
    return closure.digest


@dataclass(frozen=True)
class _Closure:
    digest: bytes
    files: dict[Path, tuple[int, int]]


@cache
def _closure(module: str) -> _Closure:
    waiting, seen = [module], {module}
    found: dict[str, str] = {}
    files: dict[Path, tuple[int, int]] = {}
    while waiting:
        name = waiting.pop()
        if owner := installed(name):
            found[owner] = ""
            continue
        own = source_file(name)
        if own is None:
            continue
        package = _package(name)
        beside = [path for path in own.parent.iterdir() if path.name.endswith(_CODE)]
        for path in beside if package else [own]:
            found[f"{package}/{path.name}"] = _read(path).digest
            files[path] = _read(path).stamp
        for other in _imports(own, package):
            if other not in seen:
                seen.add(other)
                waiting.append(other)
    if not files:
        return _Closure(b"", {})
    text = "\n".join(f"{key} {digest}" for key, digest in sorted(found.items()))
    return _Closure(hashlib.sha256(text.encode()).digest(), files)


@dataclass(frozen=True)
class _File:
    content: bytes
    digest: str
    stamp: tuple[int, int]


@cache
def _read(path: Path) -> _File:
    stamp, content = _stamp(path), path.read_bytes()
    return _File(content, hashlib.sha256(content).hexdigest(), stamp)


def _stamp(path: Path) -> tuple[int, int]:
    try:
        status = path.stat()
    except FileNotFoundError:
        return 0, 0
    return status.st_mtime_ns, status.st_size


def _package(name: str) -> str:
    spec = spec_of(name)
    return "" if spec is None else spec.parent or ""


@cache
def _imports(path: Path, package: str) -> tuple[str, ...]:
    """Names of modules that a file may import."""
    if path.suffix != ".py":
        return ()
    try:
        tree = ast.parse(_read(path).content)
    except (SyntaxError, ValueError):  # so it cannot be imported
        return ()
    return tuple(name for node in _nodes(tree) for name in _targets(node, package))


def _nodes(tree: ast.AST) -> Iterator[ast.AST]:
    """All nodes but those that only a type checker sees."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            continue
        yield node
        yield from _nodes(node)


def _targets(node: ast.AST, package: str) -> Iterator[str]:
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        yield from imported(node.module or "", [a.name for a in node.names], node.level, package)


def imported(module: str, names: list[str], level: int, package: str) -> Iterator[str]:
    """The modules that ``from module import names`` in a package stands for."""
    try:
        base = resolve_name("." * level + module, package or None)
    except ImportError:  # beyond the topmost package
        return
    if installed(base):
        yield base
        return
    for name in names:
        below = f"{base}.{name}"
        yield below if spec_of(below) is not None else base
