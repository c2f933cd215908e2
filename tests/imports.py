"""What files import, read from their text: also for type checks only, and within functions."""

import ast
from functools import cache
from pathlib import Path


def imported(*paths: Path, relative: bool = False) -> set[str]:
    """Dotted names of all that files import: modules, and names in them as ``module.name``.

    Raises
    ------
    ValueError : for a relative import, of which nothing here is seen, unless `relative` allows it.
    """
    found = set()
    for path in paths:
        absolute, lines = _imported(path)
        if lines and not relative:
            raise ValueError(f"{path}:{lines[0]} imports relatively")
        found |= absolute
    return found


@cache
def _imported(path: Path) -> tuple[frozenset[str], list[int]]:
    """Names of a file that are imported absolutely, and lines that import relatively."""
    found, relative = set(), []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level:
            relative.append(node.lineno)
        elif isinstance(node, ast.ImportFrom):
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return frozenset(found), relative


def packages(*paths: Path) -> set[str]:
    """Top-level names of all that files import."""
    return {name.partition(".")[0] for name in imported(*paths)}


@cache
def modules(package: Path) -> dict[str, Path]:
    """Files of a package by the dotted names of their modules."""
    return {_dotted(package, path): path for path in package.rglob("*.py")}


@cache
def exported(package: Path) -> dict[str, str]:
    """What its rooms export, by dotted names: ``room.name`` is ``room.module.name``."""
    found = {}
    for stub in package.rglob("__init__.pyi"):
        room = _dotted(package, stub)
        for node in ast.parse(stub.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ImportFrom):
                home = f"{room}.{node.module}" if node.module else room
                found |= {f"{room}.{alias.name}": f"{home}.{alias.name}" for alias in node.names}
    return found


def _dotted(package: Path, path: Path) -> str:
    parts = (package.name, *path.relative_to(package).with_suffix("").parts)
    return ".".join(parts).removesuffix(".__init__")


@cache
def graph(package: Path) -> dict[str, set[str]]:
    """Which modules of a package each of them imports, by dotted names."""
    return {
        name: {_module(each, package) for each in imported(path)} & modules(package).keys() - {name}
        for name, path in modules(package).items()
    }


def _module(name: str, package: Path) -> str:
    """The module that a name is, or that it is in."""
    while exported(package).get(name, name) != name:
        name = exported(package)[name]
    return name if name in modules(package) else name.rpartition(".")[0]


def rooms(package: Path, room: str) -> set[str]:
    """Which other folders of a package the modules of one import, and single modules as such."""
    inside = {n: uses for n, uses in graph(package).items() if n.split(".")[1:2] == [room]}
    return {name.split(".")[1] for uses in inside.values() for name in uses if "." in name} - {room}


def entered(names: set[str], package: Path) -> set[str]:
    """Of dotted names those of modules within rooms, which the rooms do not export."""
    within = {name for name, path in modules(package).items() if _is_within(name, path)}
    return {
        name
        for name in names - exported(package).keys()
        if name in within or name.rpartition(".")[0] in within
    }


def _is_within(name: str, path: Path) -> bool:
    return name.count(".") > 1 and path.name != "__init__.py"
