"""An algorithm as the call that makes one like it."""

import inspect
import reprlib
from collections.abc import Iterator
from typing import Any

import numpy as np

_SHORT = reprlib.Repr()
_SHORT.maxlevel, _SHORT.maxlist, _SHORT.maxtuple, _SHORT.maxstring = 1, 6, 6, 60
_SEVERAL = inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD


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
    for parameter in _parameters(type(algorithm), root):
        try:
            value = getattr(algorithm, parameter.name)
        except Exception:  # not kept, or read by foreign code; to show an object must not fail
            value = ... if parameter.default is parameter.empty else parameter.default
        if parameter.name not in shown and not _same(value, parameter.default):
            shown[parameter.name] = _text(value)
    given = ", ".join(f"{name}={text}" for name, text in shown.items())
    return f"{type(algorithm).__name__}({given})"


def _parameters(cls: type, root: type) -> Iterator[inspect.Parameter]:
    for each in cls.__mro__[: cls.__mro__.index(root)]:
        if "__init__" in vars(each):
            _, *parameters = inspect.signature(vars(each)["__init__"]).parameters.values()
            yield from (p for p in parameters if p.kind not in _SEVERAL)
            if not any(p.kind is p.VAR_KEYWORD for p in parameters):
                return


def _same(value: Any, default: Any) -> bool:
    try:
        return value is default or bool(np.array_equal(value, default))
    except Exception:  # of what cannot be compared, in whatever way it says so
        return False


def _text(value: Any) -> str:
    if value is ...:
        return "..."
    if type(value) is np.ndarray or isinstance(value, np.generic):
        value = value.tolist()
    if value is None or isinstance(value, bool | int | float | str | list | tuple | dict):
        return _SHORT.repr(value)
    return f"{type(value).__name__}(...)"
