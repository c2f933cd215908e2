"""What an algorithm's constructor takes, and the values that the algorithm keeps of it."""

import inspect
import re
import reprlib
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

_SHORT = reprlib.Repr()
_SHORT.maxlevel, _SHORT.maxlist, _SHORT.maxtuple, _SHORT.maxstring = 1, 6, 6, 60


def parameters(cls: type, root: type) -> Mapping[str, inspect.Parameter]:
    """Parameters that `cls(...)` takes by name, in order.

    Those of its constructor and, as far as each passes on what it does not name, those of the
    constructors that it inherits, `root`'s the last.
    """
    found: dict[str, inspect.Parameter] = {}
    for constructor in _constructors(cls, root):
        found |= {name: p for name, p in _named(constructor).items() if name not in found}
        if not any(p.kind is p.VAR_KEYWORD for p in _parameters(constructor)):
            break
    return found


def keywords(cls: type, root: type) -> frozenset[str]:
    """Names of the `parameters`."""
    return frozenset(parameters(cls, root))


def descriptions(cls: type) -> dict[str, str]:
    """What the docstrings of a class and of those that it inherits say of parameters, in a line."""
    found: dict[str, str] = {}
    for each in cls.__mro__:
        text = inspect.cleandoc(each.__doc__ or "").partition("Parameters\n----------\n")[2]
        entries = re.findall(r"^(\w.*) : (.+(?:\n .+)*)", text.partition("\n\n")[0], re.MULTILINE)
        for names, meaning in entries:
            line = " ".join(meaning.split()).rstrip(".")
            found = dict.fromkeys(names.split(", "), line) | found
    return found


def values(algorithm: object, root: type, leave_out: Collection[str] = ()) -> dict[str, Any]:
    """The `parameters` of an algorithm's class by name, as its attributes of these names hold them.

    Raises
    ------
    TypeError : for a constructor with `*args`, or one that does not keep a parameter.
    """
    cls = type(algorithm)
    for each in _constructors(cls, root):
        if any(p.kind is p.VAR_POSITIONAL for p in _parameters(each)):
            raise TypeError(f"{each.__name__}(*...): expected parameters that have names")
    found = {}
    for name in parameters(cls, root):
        if name not in leave_out:
            try:
                found[name] = getattr(algorithm, name)
            except AttributeError:
                raise TypeError(
                    f"{cls.__name__} has no attribute {name!r}: expected its constructor to keep "
                    "each parameter under the parameter's name"
                ) from None
    return found


def call(algorithm: object, root: type) -> str:
    """``Class(name=value, ...)`` with the parameters that are not what they are by default.

    A parameter is the attribute of its name. Where a constructor does not keep it, it is left out,
    or is ``...`` if it has no default; so is what is too long to show.
    """
    shown: dict[str, str] = {}
    for parameter in parameters(type(algorithm), root).values():
        try:
            value = getattr(algorithm, parameter.name)
        except Exception:  # not kept, or read by foreign code; to show an object must not fail
            value = ... if parameter.default is parameter.empty else parameter.default
        if not _same(value, parameter.default):
            shown[parameter.name] = _text(value)
    given = ", ".join(f"{name}={text}" for name, text in shown.items())
    return f"{type(algorithm).__name__}({given})"


def named(constructor: type) -> frozenset[str]:
    """Parameters that the `__init__` of a class names."""
    return frozenset(_named(constructor))


def _same(a: Any, b: Any) -> bool:
    try:
        return a is b or bool(np.array_equal(a, b))
    except Exception:  # of foreign values, in whatever way they say so
        return False


def _text(value: Any) -> str:
    if value is ...:
        return "..."
    if type(value) is np.ndarray or isinstance(value, np.generic):
        value = value.tolist()
    if value is None or isinstance(value, bool | int | float | str | list | tuple | dict):
        return _SHORT.repr(value)
    return f"{type(value).__name__}(...)"


def _named(constructor: type) -> dict[str, inspect.Parameter]:
    several = inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD
    return {p.name: p for p in _parameters(constructor) if p.kind not in several}


def _parameters(cls: type) -> list[inspect.Parameter]:
    _, *parameters = inspect.signature(vars(cls)["__init__"]).parameters.values()
    return parameters


def _constructors(cls: type, root: type) -> list[type]:
    """The classes with an `__init__` of their own from `cls` to `root`, which has one."""
    ancestors = cls.__mro__[: cls.__mro__.index(root) + 1]
    return [each for each in ancestors if "__init__" in vars(each)]
