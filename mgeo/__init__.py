"""Generalized extremal optimization for pymoo."""

from importlib.metadata import version

from mgeo.algorithms.real import MGEOReal
from mgeo.archive import ParetoArchive

__version__ = version("mgeo")

__all__ = ["MGEOReal", "ParetoArchive", "__version__"]
