"""Scenarios: what a study depends on, from code, presets or TOML files."""

import warnings
from typing import Any

import lazy_loader

_getattr, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """`OrbitFile` by its name when it read ephemerides only."""
    if name == "EphemerisFile":
        warnings.warn(
            "EphemerisFile is now called OrbitFile; gone in 0.4", DeprecationWarning, stacklevel=2
        )
        name = "OrbitFile"
    return _getattr(name)
