"""Generalized extremal optimization for pymoo."""

from importlib import import_module
from importlib.metadata import version
from itertools import chain
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mgeo.algorithms.archive import ParetoArchive as ParetoArchive
    from mgeo.algorithms.binary import MGEOCanonical as MGEOCanonical
    from mgeo.algorithms.binary import MGEOVar as MGEOVar
    from mgeo.algorithms.directed import MGEODirected as MGEODirected
    from mgeo.algorithms.initial_designs import SuggestedSampling as SuggestedSampling
    from mgeo.algorithms.real import MGEOReal as MGEOReal
    from mgeo.algorithms.real import MGEOReal2 as MGEOReal2
    from mgeo.algorithms.staged import MGEOStaged as MGEOStaged
    from mgeo.evaluation.evaluator import (
        EvaluationError as EvaluationError,
    )
    from mgeo.evaluation.evaluator import (
        TolerantEvaluator as TolerantEvaluator,
    )
    from mgeo.plugins.protocol import ProblemMixin as ProblemMixin
    from mgeo.plugins.view import View as View
    from mgeo.plugins.view import build_view as build_view
    from mgeo.store.checkpoint import Checkpoint as Checkpoint
    from mgeo.store.checkpoint import resume as resume
    from mgeo.store.recorder import Recorder as Recorder
    from mgeo.store.recorder import read_record as read_record
    from mgeo.studies.execute import compare as compare

#: Public names by module. A name is imported on first use, so that the command line starts
#: quickly.
_NAMES = {
    "mgeo.algorithms.archive": ["ParetoArchive"],
    "mgeo.algorithms.binary": ["MGEOCanonical", "MGEOVar"],
    "mgeo.algorithms.directed": ["MGEODirected"],
    "mgeo.algorithms.initial_designs": ["SuggestedSampling"],
    "mgeo.algorithms.real": ["MGEOReal", "MGEOReal2"],
    "mgeo.algorithms.staged": ["MGEOStaged"],
    "mgeo.evaluation.evaluator": ["EvaluationError", "TolerantEvaluator"],
    "mgeo.plugins.protocol": ["ProblemMixin"],
    "mgeo.plugins.view": ["View", "build_view"],
    "mgeo.store.checkpoint": ["Checkpoint", "resume"],
    "mgeo.store.recorder": ["Recorder", "read_record"],
    "mgeo.studies.execute": ["compare"],
}
__all__ = list(chain(*_NAMES.values()))


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return version("mgeo")
    for module, names in _NAMES.items():
        if name in names:
            return getattr(import_module(module), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
