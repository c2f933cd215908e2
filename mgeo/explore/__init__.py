"""Interactive exploration of a run in the browser: filter, modify and save solutions."""

from mgeo.explore.explorer import Explorer
from mgeo.explore.server import ExplorerServer

__all__ = [
    "Explorer",
    "ExplorerServer",
]
