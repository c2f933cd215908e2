"""Joint selection of attitude sensors and calibration maneuvers, as a pymoo problem."""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mgeo_suite.catalog import Catalog
    from mgeo_suite.problem import SensorSuiteProblem

__all__ = [
    "Catalog",
    "SensorSuiteProblem",
]

#: Module of each public name. A name is imported on first use, so that the command line starts
#: quickly.
_MODULES = {
    "Catalog": "mgeo_suite.catalog",
    "SensorSuiteProblem": "mgeo_suite.problem",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return version("mgeo-suite")
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return __all__
