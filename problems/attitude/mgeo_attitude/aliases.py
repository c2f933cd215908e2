"""What problems were asked before they had a view, and what is of mgeo-calibration now."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np

_OF_PLANS = ("describe", "promises", "answers", "limits", "remarks", "ways_out")
_FIGURES = ("figures", "solution_figures")
_OF_NONE = ("impossible", "notes", "front_summary")


def _alias(name: str, of_plans: bool) -> Callable[..., Any]:
    def method(self: Any, *given: Any, **options: Any) -> Any:
        kind, first = type(self).__name__, "X" if of_plans else ""
        warnings.warn(
            f"{kind}.{name}({first}) is now view(X).{name}(); gone in 0.4",
            DeprecationWarning,
            stacklevel=2,
        )
        if not of_plans:
            X = np.empty((0, self.n_var))
        elif given:
            X, given = given[0], given[1:]
        else:
            X = options.pop("X")
        return getattr(self.view(X), name)(*given, **options)

    method.__name__ = name
    method.__doc__ = f"Use ``view(X).{name}()``."
    return method


class ShownByView:
    """Old names of what a problem's ``view(X)`` gives."""


for _name in (*_OF_PLANS, *_FIGURES, *_OF_NONE):
    setattr(ShownByView, _name, _alias(_name, _name not in _OF_NONE))


def not_installed(what: str) -> ImportError:
    """That something is of mgeo-calibration, and how that is had."""
    return ImportError(
        f"{what} is of mgeo-calibration, which is not installed: pip install "
        "./problems/calibration in a checkout"
    )


def moved(name: str) -> Any:
    """What mgeo-calibration has of a name that was here."""
    warnings.warn(
        f"mgeo_attitude.{name} is mgeo_calibration.{name} now; gone in 0.4",
        DeprecationWarning,
        stacklevel=3,
    )
    try:
        return getattr(import_module("mgeo_calibration"), name)
    except ModuleNotFoundError as error:
        if error.name != "mgeo_calibration":
            raise
        raise not_installed(name) from error
