"""Comparison of algorithms: runs, quality indicators, statistical tests and study files.

::

    result = mgeo.compare(problem, {"MGEO": MGEOReal(), "NSGA-II": NSGA2()}, 20_000, seeds=20)
    print(result.format_overview())
    result.draw_figures()["anytime"].show()
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mgeo.studies.comparison import Comparison as Comparison
    from mgeo.studies.comparison import ComparisonWarning as ComparisonWarning
    from mgeo.studies.comparison import FailedRunsWarning as FailedRunsWarning
    from mgeo.studies.comparison import SignificanceTests as SignificanceTests
    from mgeo.studies.comparison_files import read_comparison as read_comparison
    from mgeo.studies.comparison_files import read_comparisons as read_comparisons
    from mgeo.studies.execute import compare as compare
    from mgeo.studies.indicators import NoFeasibleSolutionError as NoFeasibleSolutionError
    from mgeo.studies.study import run_study as run_study
    from mgeo.studies.study_file import Study as Study
    from mgeo.studies.study_file import read_study as read_study

#: Module of each public name. Modules are imported at first use, because `compare` must work
#: without the packages of the command line.
_MODULES = {
    "Comparison": "comparison",
    "ComparisonWarning": "comparison",
    "FailedRunsWarning": "comparison",
    "NoFeasibleSolutionError": "indicators",
    "SignificanceTests": "comparison",
    "Study": "study_file",
    "compare": "execute",
    "read_comparison": "comparison_files",
    "read_comparisons": "comparison_files",
    "read_study": "study_file",
    "run_study": "study",
}
__all__ = list(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
