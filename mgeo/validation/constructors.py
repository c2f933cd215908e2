"""Parameters of a constructor, and the values that an object keeps of them."""

import inspect
import re
import reprlib
from collections.abc import Collection, Iterable, Mapping
from itertools import takewhile
from typing import Any

import numpy as np

from mgeo.validation.arguments import did_you_mean

_SHORT = reprlib.Repr()
_SHORT.maxlevel, _SHORT.maxlist, _SHORT.maxtuple, _SHORT.maxstring = 1, 6, 6, 60


def parameters(cls: type, root: type) -> Mapping[str, inspect.Parameter]:
    """Return the parameters that `cls(...)` takes by name, in order.

    These are the parameters of its constructor and, as long as each constructor passes on
    ``**options``, those of the constructors that it inherits, up to that of `root`.
    """
    found: dict[str, inspect.Parameter] = {}
    for ancestor in cls.__mro__[: cls.__mro__.index(root) + 1]:
        if "__init__" in vars(ancestor):
            _, *own = inspect.signature(vars(ancestor)["__init__"]).parameters.values()
            for parameter in own:
                if parameter.kind in (parameter.POSITIONAL_OR_KEYWORD, parameter.KEYWORD_ONLY):
                    found.setdefault(parameter.name, parameter)
            if all(parameter.kind is not parameter.VAR_KEYWORD for parameter in own):
                break
    return found


def refuse_unknown_options(name: str, cls: type, options: Iterable[str]) -> None:
    """Refuse options that the constructor of a problem would ignore.

    The constructor of pymoo's `Problem` ignores any keyword. Options are therefore compared with
    the parameters of the problem's own constructors; those of `Problem` itself are for the class to
    set, not for its users.

    Parameters
    ----------
    name : name of the problem, for the message.
    cls : its class.
    options : names of the options.

    Raises
    ------
    ValueError
        For the first unknown option, with those that the problem takes.
    """
    own = list(takewhile(lambda base: base.__module__ != "pymoo.core.problem", cls.__mro__))
    known = sorted(parameters(cls, own[-1]))
    for option in options:
        if option not in known:
            raise ValueError(
                f"unknown option {option!r} of problem {name!r}: expected "
                f"{' or '.join(known) or 'no options'}{did_you_mean(option, known)}"
            )


def descriptions(cls: type) -> dict[str, str]:
    """Return what the docstrings of a class and its bases say of each parameter, in a line."""
    found: dict[str, str] = {}
    for each in cls.__mro__:
        text = inspect.cleandoc(each.__doc__ or "").partition("Parameters\n----------\n")[2]
        entries = re.findall(r"^(\w.*) : (.+(?:\n .+)*)", text.partition("\n\n")[0], re.MULTILINE)
        for names, meaning in entries:
            line = " ".join(meaning.split()).rstrip(".")
            found = dict.fromkeys(names.split(", "), line) | found
    return found


def values(algorithm: object, root: type, leave_out: Collection[str] = ()) -> dict[str, Any]:
    """Return the `parameters` of an algorithm by name, as its attributes of these names hold them.

    Raises
    ------
    TypeError
        If the constructor does not keep a parameter under its name.
    """
    cls = type(algorithm)
    names = [name for name in parameters(cls, root) if name not in leave_out]
    for name in names:
        if not hasattr(algorithm, name):
            raise TypeError(
                f"{cls.__name__} has no attribute {name!r}: expected its constructor to keep each "
                "parameter under the parameter's name"
            )
    return {name: getattr(algorithm, name) for name in names}


def call(algorithm: object, root: type) -> str:
    """Return ``Class(name=value, ...)`` with the parameters that do not have their default.

    A parameter that the constructor does not keep is left out, or shown as ``...`` if it has no
    default.
    """
    shown = []
    for parameter in parameters(type(algorithm), root).values():
        unknown: Any = ... if parameter.default is parameter.empty else parameter.default
        value = getattr(algorithm, parameter.name, unknown)
        if not np.array_equal(value, parameter.default):
            shown.append(f"{parameter.name}={_text(value)}")
    return f"{type(algorithm).__name__}({', '.join(shown)})"


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if value is None or isinstance(value, bool | int | float | str | list | tuple | dict):
        return _SHORT.repr(value)
    return "..." if value is ... else f"{type(value).__name__}(...)"
