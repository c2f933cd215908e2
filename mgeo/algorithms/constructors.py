"""What an algorithm's constructor takes, and its arguments read back from the algorithm."""

from __future__ import annotations

import inspect
from collections.abc import Collection
from typing import Any

import numpy as np


def keywords(cls: type, root: type) -> frozenset[str]:
    """Parameters that `cls(...)` takes by name.

    Those of its constructor and, as far as each passes on what it does not name, those of the
    constructors that it inherits, except for `root`'s.
    """
    found: frozenset[str] = frozenset()
    for constructor in _constructors(cls, root)[:-1]:
        found |= named(constructor)
        if not any(p.kind is p.VAR_KEYWORD for p in _parameters(constructor)):
            break
    return found


def arguments(algorithm: Any, root: type, leave_out: Collection[str]) -> dict[str, Any]:
    """Arguments by name with which its class makes an algorithm of the same parameters.

    They are the attributes under the names of the constructor's parameters, and of those of
    inherited constructors what would be another value otherwise.

    Parameters
    ----------
    algorithm : of the family of `root`.
    root : the first class of the family.
    leave_out : parameters that are not needed.

    Raises
    ------
    TypeError : if there are none, because the constructor's parameters are not kept under their
        names, or kept as something else than it takes.
    """
    cls = type(algorithm)
    constructors = _constructors(cls, root)
    inherited = frozenset().union(*map(named, constructors)).difference(leave_out)
    wanted = named(constructors[0]).difference(leave_out)
    refused = (
        f"{cls.__name__} cannot be made again from its attributes, and so its state not be kept"
    )
    given: dict[str, Any] = {}
    why = ""
    for _ in ("its own", "inherited"):
        try:
            given |= {key: getattr(algorithm, key) for key in sorted(wanted)}
            again = cls(**given)
        except Exception as error:  # of foreign constructors: it may raise anything
            raise TypeError(f"{refused}: {why or error}") from error
        wanted = frozenset(
            key
            for key in inherited
            if hasattr(algorithm, key) and not _same(getattr(again, key), getattr(algorithm, key))
        )
        if not wanted:
            return given
        key = min(wanted)
        why = f"{key} = {getattr(algorithm, key)!r:.80} would be {getattr(again, key)!r:.80}"
    raise TypeError(f"{refused}: {why}")


def named(constructor: type) -> frozenset[str]:
    """Parameters that the `__init__` of a class names."""
    several = inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD
    return frozenset(p.name for p in _parameters(constructor) if p.kind not in several)


def _parameters(cls: type) -> list[inspect.Parameter]:
    _, *parameters = inspect.signature(vars(cls)["__init__"]).parameters.values()
    return parameters


def _constructors(cls: type, root: type) -> list[type]:
    """The classes with an `__init__` of their own from `cls` to `root`, which has one."""
    ancestors = cls.__mro__[: cls.__mro__.index(root) + 1]
    return [each for each in ancestors if "__init__" in vars(each)]


def _same(a: Any, b: Any) -> bool:
    if a is b:
        return True
    try:
        return bool(np.array_equal(a, b))
    except Exception:  # what cannot be compared
        return False
