"""Values by their content: numbers as they are, objects as pickle takes them apart."""

from __future__ import annotations

import copyreg
import enum
import sys
from _thread import LockType, RLock
from collections.abc import Iterable
from functools import cached_property, lru_cache
from types import (
    BuiltinFunctionType,
    CellType,
    ClassMethodDescriptorType,
    CodeType,
    EllipsisType,
    FunctionType,
    GetSetDescriptorType,
    MappingProxyType,
    MemberDescriptorType,
    MethodDescriptorType,
    MethodType,
    ModuleType,
    NotImplementedType,
    WrapperDescriptorType,
)
from typing import Any, TypeVar

import numpy as np
from pymoo.core.problem import Problem

from mgeo.plugins import protocol
from mgeo.studies.fingerprint import code
from mgeo.studies.fingerprint.attributes import counted, speaks_for_itself
from mgeo.studies.fingerprint.digest import mix
from mgeo.studies.fingerprint.origins import installed
from mgeo.studies.fingerprint.uncertain import UncertainError

_ATOMS = (type(None), bool, float, complex, EllipsisType, NotImplementedType)
_BUILTIN = (
    BuiltinFunctionType,
    ClassMethodDescriptorType,
    GetSetDescriptorType,
    MemberDescriptorType,
    MethodDescriptorType,
    WrapperDescriptorType,
)
_CACHED = type(lru_cache(len))
_EMPTY = (LockType, RLock, TypeVar)  # nothing that is computed depends on them


class Walk:
    """One look at a value and all that it is made of.

    Parameters
    ----------
    vouched : the author's text, which stands for all code and for what cannot be told.
    """

    def __init__(self, vouched: str = "") -> None:
        self.vouched = vouched
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
            return mix(self.vouched, self(value, type(value).__qualname__))
        except RecursionError:
            raise UncertainError(f"{type(value).__qualname__} is nested too deeply") from None

    def __call__(self, value: Any, step: str = "") -> bytes:
        """Digest of a value that is found by `step` in the one that contains it."""
        kind = type(value)
        if kind in _ATOMS:
            return mix(kind.__name__, repr(value))
        if kind is int:
            return mix("int", hex(value))
        if kind is str:
            return mix("str", value)
        if kind is bytes:
            return mix("bytes", value)
        key = id(value)
        if key in self._known:
            return self._known[key][1]
        depth = len(self._inside)
        if key in self._inside:
            self._outermost = min(self._outermost, self._inside[key])
            return mix("its container", str(depth - self._inside[key]))
        before, self._outermost = self._outermost, sys.maxsize
        self._inside[key] = depth
        self._steps.append(step)
        digest = self._composed(value)
        self._steps.pop()
        del self._inside[key]
        if self._outermost >= depth:  # the same wherever it is found
            self._known[key] = value, digest
            self._outermost = before
        else:
            self._outermost = min(self._outermost, before)
        return digest

    def uncertain(self, reason: str) -> bytes:
        """Say that what is looked at cannot be told, unless its author vouches for it."""
        if self.vouched:
            return mix("vouched for")
        raise UncertainError(f"{''.join(self._steps)} {reason}")

    def _composed(self, value: Any) -> bytes:
        kind = type(value)
        if isinstance(value, np.generic) or kind is np.ndarray:
            return self._array(np.asarray(value), kind.__name__)
        if kind in (list, tuple):
            return mix(kind.__name__, *(self(item, f"[{i}]") for i, item in enumerate(value)))
        if kind in (set, frozenset):
            return mix(kind.__name__, *sorted(self(item, " (an element)") for item in value))
        if kind in (dict, MappingProxyType):
            return mix(kind.__name__, *self._pairs(value.items()))
        if kind is FunctionType:
            return code.function(self, value)
        if kind is CodeType:
            return code.instructions(self, value)
        if isinstance(value, type):
            return code.class_(self, value)
        if isinstance(value, ModuleType):
            return code.module(self, value.__name__)
        if kind in _BUILTIN:
            return code.builtin(self, value)
        if kind in _EMPTY:
            return mix(kind.__name__)
        if (inner := _parts(value)) is not None:
            return mix(kind.__name__, *(self(each, step) for step, each in inner))
        if isinstance(value, enum.Enum):
            return mix("enum", self(kind), self(value.value))
        if isinstance(value, Problem) and speaks_for_itself(kind):
            return mix("problem", self(kind), self(protocol.options(value), ".options()"))
        return self._object(value)

    def _array(self, value: np.ndarray[Any, Any], kind: str) -> bytes:
        shape, dtype = str(value.shape), repr(np.lib.format.dtype_to_descr(value.dtype))
        if value.dtype.hasobject:
            items = (self(item, f".flat[{i}]") for i, item in enumerate(value.ravel().tolist()))
            return mix(kind, shape, dtype, *items)
        return mix(kind, shape, dtype, np.ascontiguousarray(value).tobytes())

    def _pairs(self, pairs: Iterable[tuple[Any, Any]]) -> Iterable[bytes]:
        for key, item in pairs:
            yield self(key, f" (the key {key!r:.40})")
            yield self(item, f"[{key!r:.40}]")

    def _object(self, value: Any) -> bytes:
        kind = type(value)
        if kind.__module__.startswith("numba.") and hasattr(value, "py_func"):
            return mix("jit", self(kind), self(value.py_func), self(value.targetoptions))
        try:
            reduce = copyreg.dispatch_table.get(kind)
            taken = reduce(value) if reduce else value.__reduce_ex__(4)
        except Exception as error:  # whatever foreign code raises when it is to be pickled
            return self.uncertain(f"is a {_name(kind)}, which cannot be looked into: {error}")
        if isinstance(taken, str):
            return self._global(value, taken)
        make, arguments, state, items, pairs, setter = (*taken, None, None, None, None)[:6]
        return mix(
            "object",
            self(make),
            self(arguments),
            *self._state(value, state),
            mix(*(self(item, f"[{i}]") for i, item in enumerate(items or ()))),
            mix(*self._pairs(pairs or ())),
            self(setter),
        )

    def _state(self, value: Any, state: Any) -> Iterable[bytes]:
        own, slots = state if isinstance(state, tuple) and len(state) == 2 else (state, None)
        plain = all(isinstance(part, dict | None) for part in (own, slots))
        if not plain or (own or {}).keys() & (slots or {}).keys():
            yield self(state, " (its state)")
            return
        attributes = {**(own or {}), **(slots or {})}
        if isinstance(value, Problem) and type(value).__getstate__ is Problem.__getstate__:
            attributes = vars(value)  # with what pymoo leaves out of copies
        for key in sorted(attributes, key=str):
            for kept in counted(value, key, attributes[key]):
                yield self(key)
                yield self(kept, f".{key}")

    def _global(self, value: Any, name: str) -> bytes:
        """What pickle knows by its name alone, such as NumPy's functions."""
        places = (
            place
            for place, module in list(sys.modules.items())
            if getattr(module, "__dict__", {}).get(name) is value and installed(place)
        )
        owners = sorted({installed(place) for place in places}, key=_library_last)
        if not owners:
            return self.uncertain(f"is the {_name(type(value))} {name}, known by that name alone")
        return mix("global", owners[-1], name)


def _parts(value: Any) -> list[tuple[str, Any]] | None:
    """What wrappers of functions that pickle does not know are made of."""
    kind = type(value)
    if kind is MethodType:
        return [(".__func__", value.__func__), (".__self__", value.__self__)]
    if kind is CellType:
        return [("", value.cell_contents)] if _filled(value) else []
    if kind is property:
        return [(".fget", value.fget), (".fset", value.fset), (".fdel", value.fdel)]
    if kind is cached_property:
        return [(".func", value.func)]
    if kind in (staticmethod, classmethod, _CACHED):
        return [(".__wrapped__", value.__wrapped__)]
    return None


def _filled(cell: CellType) -> bool:
    try:
        _ = cell.cell_contents
    except ValueError:
        return False
    return True


def _library_last(owner: str) -> tuple[bool, str]:
    return owner in ("numpy", "scipy"), owner  # others may only pass on what is theirs


def _name(kind: type) -> str:
    return f"{kind.__module__}.{kind.__qualname__}".removeprefix("builtins.")
