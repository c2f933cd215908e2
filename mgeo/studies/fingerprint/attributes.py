"""Which attributes of problems and other objects say what they compute."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from pymoo.core.meta import Meta
from pymoo.core.problem import Problem

_NOT_WHAT = ("elementwise_runner",)  # of a problem: where its elements are evaluated


def speaks_for_itself(cls: type) -> bool:
    """Whether the ``options()`` of a problem's class know all that its constructor takes."""
    speaker, maker = (
        next((each for each in cls.__mro__ if name in vars(each)), object)
        for name in ("options", "__init__")
    )
    return speaker is not object and issubclass(speaker, maker)


def counted(value: Any, key: str, attribute: Any) -> tuple[Any, ...]:
    """An attribute without what is no more than a memory of what was computed; perhaps nothing."""
    if isinstance(getattr(type(value), key, None), cached_property):
        return ()
    if isinstance(value, Meta) and key == "__super__":  # has the same attributes, but in no copy
        return ()
    if isinstance(value, Problem):
        if key in _NOT_WHAT:
            return ()
        if key == "cache" and isinstance(attribute, dict):  # where pymoo keeps its fronts
            others = {name: each for name, each in attribute.items() if not hasattr(Problem, name)}
            return (others,) if others else ()
    return (attribute,)
