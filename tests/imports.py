"""What files import, read from their text: also for type checks only, and within functions."""

import ast
from functools import cache
from pathlib import Path


def imported(*paths: Path) -> set[str]:
    """Dotted names of all that files import: modules, and names in them as ``module.name``.

    Raises
    ------
    ValueError : for a relative import, of which nothing here is seen.
    """
    found = set()
    for path in paths:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                if node.level:
                    raise ValueError(f"{path}:{node.lineno} imports relatively")
                found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def packages(*paths: Path) -> set[str]:
    """Top-level names of all that files import."""
    return {name.partition(".")[0] for name in imported(*paths)}


@cache
def graph(package: Path) -> dict[str, set[str]]:
    """Which modules of a package each of them imports, by dotted names."""
    paths = {}
    for path in package.rglob("*.py"):
        parts = (package.name, *path.relative_to(package).with_suffix("").parts)
        paths[".".join(parts).removesuffix(".__init__")] = path
    return {name: _modules(imported(path), paths) - {name} for name, path in paths.items()}


def _modules(names: set[str], known: dict[str, Path]) -> set[str]:
    """Of each name the module that it is, or that it is in."""
    return {name if name in known else name.rpartition(".")[0] for name in names} & known.keys()


def rooms(package: Path, room: str) -> set[str]:
    """Which other folders of a package the modules of one import, and single modules as such."""
    inside = {n: uses for n, uses in graph(package).items() if n.split(".")[1:2] == [room]}
    return {name.split(".")[1] for uses in inside.values() for name in uses if "." in name} - {room}
