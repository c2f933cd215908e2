"""Constructor parameters of a class, and their values on an instance.

Algorithms store each parameter as an attribute of the same name, as scikit-learn estimators do.
"""

import inspect
import re
import reprlib
from collections.abc import Collection, Iterable, Mapping
from itertools import takewhile
from typing import Any

import numpy as np

from mgeo.validation.arguments import format_suggestion

_SHORT_REPR = reprlib.Repr()
_SHORT_REPR.maxlevel, _SHORT_REPR.maxlist, _SHORT_REPR.maxtuple, _SHORT_REPR.maxstring = 1, 6, 6, 60


def get_parameters(cls: type, root: type) -> Mapping[str, inspect.Parameter]:
    """Return all constructor parameters of a class, including inherited ones.

    If the constructor accepts ``**options``, the parameters of the next constructor in the method
    resolution order follow, and so on up to the constructor of `root`.

    Parameters
    ----------
    cls : type
    root : type
        Base class of `cls` at which the search ends.

    Returns
    -------
    dict of str to inspect.Parameter
    """
    collected: dict[str, inspect.Parameter] = {}
    for ancestor in cls.__mro__[: cls.__mro__.index(root) + 1]:
        if "__init__" in vars(ancestor):
            _, *declared = inspect.signature(vars(ancestor)["__init__"]).parameters.values()
            for parameter in declared:
                if parameter.kind in (parameter.POSITIONAL_OR_KEYWORD, parameter.KEYWORD_ONLY):
                    collected.setdefault(parameter.name, parameter)
            if all(parameter.kind is not parameter.VAR_KEYWORD for parameter in declared):
                break
    return collected


def reject_unknown_options(name: str, cls: type, options: Iterable[str]) -> None:
    """Raise ValueError if an option is unknown to the constructor of a problem class.

    The constructor of pymoo's `Problem` silently ignores unknown keywords. Allowed are therefore
    only the parameters of the constructors of derived classes, not those of `Problem`.

    Parameters
    ----------
    name : str
        Name of the problem, for the message.
    cls : type
        Class of the problem.
    options : iterable of str
        Names of the options.
    """
    derived = list(takewhile(lambda base: base.__module__ != "pymoo.core.problem", cls.__mro__))
    known = sorted(get_parameters(cls, derived[-1]))
    for option in options:
        if option not in known:
            raise ValueError(
                f"unknown option {option!r} of problem {name!r}: expected "
                f"{' or '.join(known) or 'no options'}{format_suggestion(option, known)}"
            )


def get_parameter_descriptions(cls: type) -> dict[str, str]:
    """Collect parameter descriptions from the docstrings of a class and its bases.

    The docstrings have entries ``name : description`` in their section Parameters.

    Returns
    -------
    dict of str to str
        Descriptions in one line without a final period, keyed by parameter name.
    """
    lines: dict[str, str] = {}
    for each in cls.__mro__:
        text = inspect.cleandoc(each.__doc__ or "").partition("Parameters\n----------\n")[2]
        entries = re.findall(r"^(\w.*) : (.+(?:\n .+)*)", text.partition("\n\n")[0], re.MULTILINE)
        for names, description in entries:
            line = " ".join(description.split()).rstrip(".")
            lines = dict.fromkeys(names.split(", "), line) | lines
    return lines


def get_parameter_values(
    algorithm: object, root: type, exclude: Collection[str] = ()
) -> dict[str, Any]:
    """Return a dict with the values of all constructor parameters of an algorithm.

    Parameters
    ----------
    algorithm : object
        Instance that stores each parameter as an attribute of the same name.
    root : type
        Base class, see `get_parameters`.
    exclude : collection of str
        Parameters to omit.

    Raises
    ------
    TypeError
        If the instance lacks the attribute of a parameter.
    """
    cls = type(algorithm)
    names = [name for name in get_parameters(cls, root) if name not in exclude]
    for name in names:
        if not hasattr(algorithm, name):
            raise TypeError(
                f"{cls.__name__} has no attribute {name!r}: expected its constructor to store each "
                "parameter as an attribute of the same name"
            )
    return {name: getattr(algorithm, name) for name in names}


def format_call(algorithm: object, root: type) -> str:
    """Format an algorithm as a constructor call, ``Class(name=value, ...)``.

    Parameters with their default value are omitted. A parameter without an attribute of its name is
    omitted, or printed as ``...`` if it has no default.

    Parameters
    ----------
    algorithm : object
    root : type
        Base class, see `get_parameters`.
    """
    arguments = []
    for parameter in get_parameters(type(algorithm), root).values():
        fallback: Any = ... if parameter.default is parameter.empty else parameter.default
        value = getattr(algorithm, parameter.name, fallback)
        if not np.array_equal(value, parameter.default):
            arguments.append(f"{parameter.name}={_format_value(value)}")
    return f"{type(algorithm).__name__}({', '.join(arguments)})"


def _format_value(value: Any) -> str:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if value is None or isinstance(value, bool | int | float | str | list | tuple | dict):
        return _SHORT_REPR.repr(value)
    return "..." if value is ... else f"{type(value).__name__}(...)"
