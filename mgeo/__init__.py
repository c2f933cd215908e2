"""Generalized extremal optimization for pymoo."""

from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from mgeo.algorithms import MGEOCanonical, MGEOReal, MGEOReal2, MGEOVar
from mgeo.archive import ParetoArchive
from mgeo.evaluation import EvaluationError, TolerantEvaluator

if TYPE_CHECKING:
    from mgeo.studies import compare

__version__ = version("mgeo")

__all__ = [
    "EvaluationError",
    "MGEOCanonical",
    "MGEOReal",
    "MGEOReal2",
    "MGEOVar",
    "ParetoArchive",
    "TolerantEvaluator",
    "__version__",
    "compare",
]


def __getattr__(name: str) -> Any:
    # Statistics and tables take more than a second to import, and most uses need none.
    if name == "compare":
        from mgeo.studies import compare

        return compare
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
