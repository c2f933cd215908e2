"""Values by their content: numbers as they are, objects as pickle takes them apart."""

from __future__ import annotations

import copyreg
import enum
import hashlib
import sys
from _thread import LockType, RLock
from collections.abc import Iterable
from functools import cached_property
from types import (
    BuiltinFunctionType,
    EllipsisType,
    FunctionType,
    MappingProxyType,
    ModuleType,
    NotImplementedType,
)
from typing import Any, TypeVar

import numpy as np
from pymoo.core.meta import Meta
from pymoo.core.problem import Problem

from mgeo.plugins import protocol
from mgeo.studies.fingerprint.code import (
    ATTRIBUTES,
    Part,
    Parts,
    Unknown,
    builtin_parts,
    class_parts,
    function_parts,
    module_parts,
)
from mgeo.studies.fingerprint.modules import UncertainError, installed

_ATOMS = (type(None), bool, float, complex, EllipsisType, NotImplementedType)
_EMPTY = (LockType, RLock, TypeVar)  # nothing that is computed depends on them


class Walk:
    """One look at a value and all that it is made of.

    Parameters
    ----------
    vouched : the author's text, which stands for all code and for what cannot be told.
    """

    def __init__(self, vouched: str = "") -> None:
        self._vouched = vouched
        self._steps: list[str] = []
        self._inside: dict[int, int] = {}  # depths of the objects that contain this one, by id
        self._known: dict[int, tuple[Any, bytes]] = {}  # with the object, lest its id is reused
        self._outermost = sys.maxsize  # depth of the container that something below refers to

    def whole(self, value: Any) -> bytes:
        """Digest of a problem, an algorithm or anything else.

        Raises
        ------
        UncertainError
            Of which the message names the first thing that cannot be told, and where it is.
        """
        try:
            return _mix([self._vouched, self._digest(value, type(value).__qualname__)])
        except RecursionError:
            raise UncertainError(f"{type(value).__qualname__} is nested too deeply") from None

    def _digest(self, value: Any, step: str) -> bytes:
        """Of a value that is found by `step` in the one that contains it."""
        kind = type(value)
        if kind in _ATOMS:
            return _mix([kind.__name__, repr(value)])
        if kind in (int, str, bytes):
            return _mix([kind.__name__, hex(value) if kind is int else value])
        key = id(value)
        if key in self._known:
            return self._known[key][1]
        depth = len(self._inside)
        if key in self._inside:
            self._outermost = min(self._outermost, self._inside[key])
            return _mix(["its container", str(depth - self._inside[key])])
        before, self._outermost = self._outermost, sys.maxsize
        self._inside[key] = depth
        self._steps.append(step)
        digests = [self._bytes(part) for part in _parts(value, bool(self._vouched))]
        # the order of a set's elements says nothing
        digest = _mix(sorted(digests) if kind in (set, frozenset) else digests)
        self._steps.pop()
        del self._inside[key]
        if self._outermost >= depth:  # the same wherever it is found
            self._known[key] = value, digest
            self._outermost = before
        else:
            self._outermost = min(self._outermost, before)
        return digest

    def _bytes(self, part: str | bytes | Part | Unknown) -> bytes:
        if isinstance(part, Part):
            return self._digest(part.value, part.step)
        if isinstance(part, Unknown) and not self._vouched:
            raise UncertainError(f"{''.join(self._steps)} {part.reason}")
        text = "vouched for" if isinstance(part, Unknown) else part
        return text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text


def _parts(value: Any, vouched: bool) -> Parts:
    """What a value is made of, after the name of its kind."""
    kind = type(value)
    if isinstance(value, np.generic) or kind is np.ndarray:
        yield kind.__name__
        yield from _array_parts(np.asarray(value))
    elif kind in (list, tuple, set, frozenset):
        yield kind.__name__
        yield from _items(value)
    elif kind in (dict, MappingProxyType):
        yield kind.__name__
        yield from _pairs(value.items())
    elif kind is FunctionType:
        yield from function_parts(value, vouched)
    elif isinstance(value, type):
        yield from class_parts(value, vouched)
    elif isinstance(value, ModuleType):
        yield from module_parts(value, vouched)
    elif kind is BuiltinFunctionType:
        yield from builtin_parts(value)
    elif kind in _EMPTY:
        yield kind.__name__
    elif kind in ATTRIBUTES:
        yield kind.__name__
        yield from (Part(getattr(value, key), f".{key}") for key in ATTRIBUTES[kind])
    elif isinstance(value, enum.Enum):
        yield from ("enum", Part(kind), Part(value.value))
    elif isinstance(value, Problem) and has_all_options(kind):
        yield from ("problem", Part(kind), Part(protocol.options(value), ".options()"))
    elif kind.__module__.startswith("numba.") and hasattr(value, "py_func"):
        yield from ("jit", Part(kind), Part(value.py_func), Part(value.targetoptions))
    else:
        yield from _object_parts(value)


def _array_parts(value: np.ndarray[Any, Any]) -> Parts:
    yield from (str(value.shape), repr(np.lib.format.dtype_to_descr(value.dtype)))
    if value.dtype.hasobject:
        yield from _items(value.ravel().tolist(), ".flat")
    else:
        yield np.ascontiguousarray(value).tobytes()


def _items(items: Iterable[Any], name: str = "") -> Parts:
    return (Part(item, f"{name}[{i}]") for i, item in enumerate(items))


def _pairs(pairs: Iterable[tuple[Any, Any]]) -> Parts:
    for key, item in pairs:
        yield Part(key, f" (the key {key!r:.40})")
        yield Part(item, f"[{key!r:.40}]")


def _object_parts(value: Any) -> Parts:
    kind = type(value)
    name = f"{kind.__module__}.{kind.__qualname__}".removeprefix("builtins.")
    try:
        reduce = copyreg.dispatch_table.get(kind)
        taken = reduce(value) if reduce else value.__reduce_ex__(4)
    except Exception as error:  # whatever foreign code raises when it is to be pickled
        yield Unknown(f"is a {name}, which cannot be looked into: {error}")
        return
    if isinstance(taken, str):  # what pickle knows by its name alone, such as NumPy's functions
        owner = _owner(value, taken)
        yield from ("global", taken, owner)
        if not owner:
            yield Unknown(f"is the {name} {taken}, known by that name alone")
        return
    make, arguments, state, items, pairs, setter = (*taken, None, None, None, None)[:6]
    yield from ("object", Part(make), Part(arguments), Part(setter))
    yield from _state_parts(value, state)
    yield "items"
    yield from _items(items or ())
    yield "pairs"
    yield from _pairs(pairs or ())


def _state_parts(value: Any, state: Any) -> Parts:
    own, slots = state if isinstance(state, tuple) and len(state) == 2 else (state, None)
    plain = all(isinstance(part, dict | None) for part in (own, slots))
    if not plain or (own or {}).keys() & (slots or {}).keys():
        yield Part(state, " (its state)")
        return
    attributes = {**(own or {}), **(slots or {})}
    if isinstance(value, Problem) and type(value).__getstate__ is Problem.__getstate__:
        attributes = vars(value)  # with what pymoo leaves out of copies
    for key in sorted(attributes, key=str):
        found = attributes[key]
        if isinstance(value, Problem) and key == "cache" and isinstance(found, dict):
            # without the fronts that pymoo keeps there
            found = {name: each for name, each in found.items() if not hasattr(Problem, name)}
            if not found:
                continue
        if not _idle(value, key):
            yield from (Part(key), Part(found, f".{key}"))


def _idle(value: Any, key: str) -> bool:
    """Whether an attribute is no more than a memory of what was computed, or where."""
    return (
        isinstance(getattr(type(value), key, None), cached_property)
        or (isinstance(value, Meta) and key == "__super__")  # the same attributes, but in no copy
        or (isinstance(value, Problem) and key == "elementwise_runner")
    )


def has_all_options(cls: type) -> bool:
    """Whether the ``options()`` of a problem's class know all that its constructor takes."""
    speaker, maker = (
        next((each for each in cls.__mro__ if name in vars(each)), object)
        for name in ("options", "__init__")
    )
    return speaker is not object and issubclass(speaker, maker)


def _owner(value: Any, name: str) -> str:
    """The distribution in whose modules a value has this name; empty if there is none."""
    owners = {
        installed(place)
        for place, module in list(sys.modules.items())
        if getattr(module, "__dict__", {}).get(name) is value
    }
    # others than these may only pass on what is theirs
    return max(owners | {""}, key=lambda owner: (owner in ("numpy", "scipy"), owner))


def _mix(parts: Iterable[str | bytes]) -> bytes:
    """SHA-256 of texts and digests, each after its length."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode("utf-8", "surrogatepass") if isinstance(part, str) else part
        digest.update(len(data).to_bytes(8, "big"))
        digest.update(data)
    return digest.digest()
