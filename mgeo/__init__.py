"""Generalized extremal optimization for pymoo."""

from importlib import import_module
from typing import Any

import lazy_loader

_getattr, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("mgeo")
    return _getattr(name)
