"""Which attitude sensors to fly, chosen together with how to calibrate them, as a pymoo problem."""

from importlib import import_module
from typing import Any

import lazy_loader

_getattr, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("mgeo-suite")
    return _getattr(name)
