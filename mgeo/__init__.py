"""Generalized extremal optimization for pymoo."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mgeo.algorithms import (
        MGEOCanonical,
        MGEODirected,
        MGEOReal,
        MGEOReal2,
        MGEOStaged,
        MGEOVar,
    )
    from mgeo.algorithms.archive import ParetoArchive
    from mgeo.algorithms.starting import SuggestedSampling
    from mgeo.evaluation.evaluator import EvaluationError, TolerantEvaluator
    from mgeo.plugins.view import View, view_of
    from mgeo.store.checkpoint import Checkpoint, resume
    from mgeo.store.recorder import Recorder, read_record
    from mgeo.studies import compare

__version__: str

__all__ = [
    "Checkpoint",
    "EvaluationError",
    "MGEOCanonical",
    "MGEODirected",
    "MGEOReal",
    "MGEOReal2",
    "MGEOStaged",
    "MGEOVar",
    "ParetoArchive",
    "Recorder",
    "SuggestedSampling",
    "TolerantEvaluator",
    "View",
    "__version__",
    "compare",
    "read_record",
    "resume",
    "view_of",
]

_HOMES = {
    "mgeo.algorithms": (
        "MGEOCanonical",
        "MGEODirected",
        "MGEOReal",
        "MGEOReal2",
        "MGEOStaged",
        "MGEOVar",
    ),
    "mgeo.algorithms.archive": ("ParetoArchive",),
    "mgeo.algorithms.starting": ("SuggestedSampling",),
    "mgeo.plugins.view": ("View", "view_of"),
    "mgeo.store.checkpoint": ("Checkpoint", "resume"),
    "mgeo.evaluation.evaluator": ("EvaluationError", "TolerantEvaluator"),
    "mgeo.store.recorder": ("Recorder", "read_record"),
    "mgeo.studies": ("compare",),
}


def __getattr__(name: str) -> Any:
    # algorithms and statistics take a second to import, and help and completion need none
    if name == "__version__":
        return import_module("importlib.metadata").version("mgeo")
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(home), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
