"""What an algorithm's constructor takes, and its arguments read back from the algorithm."""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Callable, Collection, Mapping
from typing import Any, TypeVar, cast

import numpy as np

F = TypeVar("F", bound=Callable[..., None])


def with_n_walkers(keywords: Mapping[str, Any]) -> dict[str, Any]:
    """Keywords with `n_walkers` where `n_runs`, the papers' n_i, was given.

    Raises
    ------
    TypeError : if both are given.
    """
    if {"n_runs", "n_walkers"} <= keywords.keys():
        raise TypeError(
            f"n_walkers = {keywords['n_walkers']!r} and n_runs = {keywords['n_runs']!r}: expected "
            "one of them, n_runs is another name of n_walkers"
        )
    return {"n_walkers" if key == "n_runs" else key: value for key, value in keywords.items()}


def takes_n_runs(constructor: F) -> F:
    """Let a constructor with `n_walkers` and `**options` take `n_runs` in place of the former."""
    signature = inspect.signature(constructor)

    @functools.wraps(constructor)
    def construct(*args: Any, **kwargs: Any) -> None:
        if "n_runs" in kwargs:
            named = signature.bind(*args, **kwargs).arguments
            args, kwargs = (), with_n_walkers({**named.pop("options"), **named})
        constructor(*args, **kwargs)

    return cast(F, construct)


def parameters(cls: type, root: type) -> Mapping[str, inspect.Parameter]:
    """Parameters that `cls(...)` takes by name, in order.

    Those of its constructor and, as far as each passes on what it does not name, those of the
    constructors that it inherits, except for `root`'s.
    """
    found: dict[str, inspect.Parameter] = {}
    for constructor in _constructors(cls, root)[:-1]:
        found |= {name: p for name, p in _named(constructor).items() if name not in found}
        if not any(p.kind is p.VAR_KEYWORD for p in _parameters(constructor)):
            break
    return found


def keywords(cls: type, root: type) -> frozenset[str]:
    """Names of the `parameters`."""
    return frozenset(parameters(cls, root))


def descriptions(cls: type) -> dict[str, str]:
    """What the docstring of a class says of each parameter, in a line."""
    _, _, section = (inspect.getdoc(cls) or "").partition("Parameters\n----------\n")
    entries = re.findall(r"^(\w+) : (.+(?:\n .+)*)", section.partition("\n\n")[0], re.MULTILINE)
    return {name: " ".join(text.split()).rstrip(".") for name, text in entries}


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
            if hasattr(algorithm, key) and not same(getattr(again, key), getattr(algorithm, key))
        )
        if not wanted:
            return given
        key = min(wanted)
        why = f"{key} = {getattr(algorithm, key)!r:.80} would be {getattr(again, key)!r:.80}"
    raise TypeError(f"{refused}: {why}")


def named(constructor: type) -> frozenset[str]:
    """Parameters that the `__init__` of a class names."""
    return frozenset(_named(constructor))


def same(a: Any, b: Any) -> bool:
    """Whether two values of a parameter are equal; not if they cannot be compared."""
    try:
        return a is b or bool(np.array_equal(a, b))
    except Exception:  # of foreign values, in whatever way they say so
        return False


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
