"""Studies: algorithms compared on equal terms, resumable, on one machine or many.

::

    result = mgeo.compare(problem, {"MGEO": MGEOReal(), "NSGA-II": NSGA2()}, 20_000, seeds=20)
    print(result.overview())
    result.figures()["anytime"].show()
"""

from mgeo.studies.comparison import Comparison, Tests
from mgeo.studies.execute import compare

__all__ = ["Comparison", "Tests", "compare"]
