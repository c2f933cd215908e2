"""Generalized extremal optimization for pymoo."""

from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from mgeo.algorithms import MGEOCanonical, MGEODirected, MGEOReal, MGEOReal2, MGEOVar
from mgeo.archive import ParetoArchive
from mgeo.checkpoint import Checkpoint, resume
from mgeo.evaluation import EvaluationError, TolerantEvaluator
from mgeo.recorder import Recorder, read_record

if TYPE_CHECKING:
    from mgeo.studies import compare

__version__ = version("mgeo")

__all__ = [
    "Checkpoint",
    "EvaluationError",
    "MGEOCanonical",
    "MGEODirected",
    "MGEOReal",
    "MGEOReal2",
    "MGEOVar",
    "ParetoArchive",
    "Recorder",
    "TolerantEvaluator",
    "__version__",
    "compare",
    "read_record",
    "resume",
]


def __getattr__(name: str) -> Any:
    # Statistics and tables take more than a second to import, and most uses need none.
    if name == "compare":
        from mgeo.studies import compare

        return compare
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
