"""The calibration filter: a declared error model, a reference filter and a generated kernel."""

from .evaluator import Evaluation, evaluate
from .model import FilterModel
from .reference import FilterHistory, reference_run
from .suite import Suite

__all__ = ["Evaluation", "FilterHistory", "FilterModel", "Suite", "evaluate", "reference_run"]
