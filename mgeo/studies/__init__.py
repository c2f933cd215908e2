"""Studies: algorithms compared on equal terms, resumable, on one machine or many.

::

    result = mgeo.compare(problem, {"MGEO": MGEOReal(), "NSGA-II": NSGA2()}, 20_000, seeds=20)
    print(result.overview())
    result.figures()["anytime"].show()
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
