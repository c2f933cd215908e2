"""Whether a run found on disk is the run asked for: problems and algorithms by their content."""

from __future__ import annotations

import hashlib
import json
from functools import cached_property
from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo import contract

_CACHES = {"cache", "data"}  # pymoo's: filled while an object is used, and nothing depends on it


def fingerprint(*parts: Any) -> str:
    """Twelve hexadecimal digits that are the same, in any process, for objects made alike.

    Of an object count its class and attributes, except those that are computed from others: a
    problem's cached properties and pymoo's caches. A problem with ``options()`` is its class and
    these options. What is no data (a function, a connection) counts by its name or type.

    Raises
    ------
    PluginError
        If a problem's ``options()`` fails, or gives no dict.
    """
    text = json.dumps([_plain(part, ()) for part in parts], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def _plain(value: Any, inside: tuple[int, ...]) -> Any:
    """The value as JSON; `inside` are the ids of the objects that contain it."""
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float | complex | bytes | np.generic):
        return repr(value)
    if id(value) in inside:
        return "its container"
    inside = (*inside, id(value))
    if isinstance(value, np.ndarray) and value.dtype != object:
        digest = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return [str(value.dtype), list(value.shape), digest]
    if isinstance(value, list | tuple | np.ndarray):
        return [_plain(item, inside) for item in value]
    if isinstance(value, set | frozenset):
        return sorted(json.dumps(_plain(item, inside), sort_keys=True) for item in value)
    if isinstance(value, dict):
        return [[_plain(key, inside), _plain(item, inside)] for key, item in value.items()]
    if isinstance(value, type) or hasattr(value, "__qualname__"):
        return f"{getattr(value, '__module__', '')}.{value.__qualname__}"
    return _object(value, inside)


def _object(value: Any, inside: tuple[int, ...]) -> list[Any]:
    cls = type(value)
    name = f"{cls.__module__}.{cls.__qualname__}"
    if isinstance(value, Problem) and hasattr(value, "options"):
        return [name, _plain(contract.options(value), inside)]
    if isinstance(value, np.random.Generator):
        return [name, _plain(value.bit_generator.state, inside)]
    attributes = {
        key: _plain(item, inside)
        for key, item in sorted(getattr(value, "__dict__", {}).items())
        if key not in _CACHES and not isinstance(getattr(cls, key, None), cached_property)
    }
    return [name, attributes]
