"""Interactive exploration of a run in the browser."""

from mgeo.explore.explorer import Explorer
from mgeo.explore.server import ExplorerServer

__all__ = [
    "Explorer",
    "ExplorerServer",
]
