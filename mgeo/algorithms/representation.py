"""An algorithm as the call that makes one like it."""

import reprlib
from typing import Any

import numpy as np

from mgeo.algorithms.constructors import parameters, same

_SHORT = reprlib.Repr()
_SHORT.maxlevel, _SHORT.maxlist, _SHORT.maxtuple, _SHORT.maxstring = 1, 6, 6, 60


def call(algorithm: object, root: type) -> str:
    """``Class(name=value, ...)`` with the parameters that are not what they are by default.

    A parameter is the attribute of its name. Where a constructor does not keep it, it is left out,
    or is ``...`` if it has no default; so is what is too long to show.

    Parameters
    ----------
    algorithm : any instance, set up or not.
    root : the class up to which constructors that pass on keywords are followed, itself left out.
    """
    shown: dict[str, str] = {}
    for parameter in parameters(type(algorithm), root).values():
        try:
            value = getattr(algorithm, parameter.name)
        except Exception:  # not kept, or read by foreign code; to show an object must not fail
            value = ... if parameter.default is parameter.empty else parameter.default
        if not same(value, parameter.default):
            shown[parameter.name] = _text(value)
    given = ", ".join(f"{name}={text}" for name, text in shown.items())
    return f"{type(algorithm).__name__}({given})"


def _text(value: Any) -> str:
    if value is ...:
        return "..."
    if type(value) is np.ndarray or isinstance(value, np.generic):
        value = value.tolist()
    if value is None or isinstance(value, bool | int | float | str | list | tuple | dict):
        return _SHORT.repr(value)
    return f"{type(value).__name__}(...)"
