"""Studies: algorithms compared on equal terms, resumable, on one machine or many.

::

    result = mgeo.compare(problem, {"MGEO": MGEOReal(), "NSGA-II": NSGA2()}, 20_000, seeds=20)
    print(result.overview())
    result.figures()["anytime"].show()
"""

from mgeo.studies.comparison import Comparison, Tests
from mgeo.studies.execute import compare
from mgeo.studies.file import Study, read_study
from mgeo.studies.indicators import NothingToCompareError
from mgeo.studies.results import FailedRunsWarning, NotReusedWarning
from mgeo.studies.stored import read_comparison, read_comparisons
from mgeo.studies.study import run_study

__all__ = [
    "Comparison",
    "FailedRunsWarning",
    "NotReusedWarning",
    "NothingToCompareError",
    "Study",
    "Tests",
    "compare",
    "read_comparison",
    "read_comparisons",
    "read_study",
    "run_study",
]
