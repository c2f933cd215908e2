"""A run as a local page on which solutions are filtered, changed and saved."""

from mgeo.explore.explorer import Explorer
from mgeo.explore.server import ExplorerServer

__all__ = [
    "Explorer",
    "ExplorerServer",
]
