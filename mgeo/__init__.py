"""Generalized extremal optimization for pymoo."""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mgeo.algorithms.archive import ParetoArchive
    from mgeo.algorithms.binary import MGEOCanonical, MGEOVar
    from mgeo.algorithms.directed import MGEODirected
    from mgeo.algorithms.real import MGEOReal, MGEOReal2
    from mgeo.algorithms.staged import MGEOStaged
    from mgeo.algorithms.starting import SuggestedSampling
    from mgeo.evaluation.evaluator import EvaluationError, TolerantEvaluator
    from mgeo.plugins.protocol import ProblemMixin
    from mgeo.plugins.view import View, view_of
    from mgeo.store.checkpoint import Checkpoint, resume
    from mgeo.store.recorder import Recorder, read_record
    from mgeo.studies.execute import compare

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
    "ProblemMixin",
    "Recorder",
    "SuggestedSampling",
    "TolerantEvaluator",
    "View",
    "compare",
    "read_record",
    "resume",
    "view_of",
]

#: Modules of the public names. A name is imported when it is first used, so that the command
#: line starts quickly.
_MODULES = {
    "Checkpoint": "mgeo.store.checkpoint",
    "EvaluationError": "mgeo.evaluation.evaluator",
    "MGEOCanonical": "mgeo.algorithms.binary",
    "MGEODirected": "mgeo.algorithms.directed",
    "MGEOReal": "mgeo.algorithms.real",
    "MGEOReal2": "mgeo.algorithms.real",
    "MGEOStaged": "mgeo.algorithms.staged",
    "MGEOVar": "mgeo.algorithms.binary",
    "ParetoArchive": "mgeo.algorithms.archive",
    "ProblemMixin": "mgeo.plugins.protocol",
    "Recorder": "mgeo.store.recorder",
    "SuggestedSampling": "mgeo.algorithms.starting",
    "TolerantEvaluator": "mgeo.evaluation.evaluator",
    "View": "mgeo.plugins.view",
    "compare": "mgeo.studies.execute",
    "read_record": "mgeo.store.recorder",
    "resume": "mgeo.store.checkpoint",
    "view_of": "mgeo.plugins.view",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return version("mgeo")
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return __all__
