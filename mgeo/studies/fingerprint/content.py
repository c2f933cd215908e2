"""Values by their content, functions and classes by their code: `joblib.hash`, and what it lacks.

joblib hashes what pickle would write, and that has only the names of functions and classes. Here
these count by the module that they come from (see `modules`); those of a script or a notebook, made
within others, or put in the place of others, by their bytecode and all that it names.
"""

from __future__ import annotations

import dis
import sys
from _thread import LockType, RLock
from collections.abc import Iterator
from functools import cached_property, lru_cache
from types import (
    BuiltinFunctionType,
    CodeType,
    FunctionType,
    MethodType,
    ModuleType,
)
from typing import Any

import numpy as np
from joblib.hashing import Hasher, NumpyHasher
from pymoo.core.problem import Problem

from mgeo.studies.fingerprint.modules import (
    UncertainError,
    code_of,
    imported,
    installed,
    source_file,
)

_CODE = (
    "co_code", "co_exceptiontable", "co_consts", "co_names", "co_varnames", "co_freevars",
    "co_cellvars", "co_argcount", "co_posonlyargcount", "co_kwonlyargcount", "co_flags",
)  # fmt: skip
#: What wraps a function, and the attributes that say what it does.
_WRAPPERS: dict[type, tuple[str, ...]] = {
    MethodType: ("__func__", "__self__"),
    BuiltinFunctionType: ("__name__", "__module__", "__self__"),
    property: ("fget", "fset", "fdel"),
    cached_property: ("func",),
    staticmethod: ("__wrapped__",),
    classmethod: ("__wrapped__",),
    type(lru_cache(len)): ("__wrapped__",),
}
_LOCKS = (LockType, RLock)  # nothing that is computed depends on them
#: Entries of a class that say nothing of what it computes, or that others say.
_IDLE = {
    "__abstractmethods__", "__annotations__", "__dict__", "__doc__", "__firstlineno__",
    "__match_args__", "__module__", "__orig_bases__", "__parameters__", "__slotnames__",
    "__slots__", "__static_attributes__", "__type_params__", "__weakref__", "_abc_impl",
    "_value2member_map_",
}  # fmt: skip
_IDLE_PREFIXES = ("__annotat", "__dataclass_")


def digest(value: Any, name: str, *, vouched: bool = False) -> str:
    """32 hexadecimal digits of a value that is called `name`.

    Parameters
    ----------
    vouched : whether its author vouches for code, so that functions and classes count by name.

    Raises
    ------
    UncertainError
        If it cannot be looked into.
    """
    try:
        return str(_Hasher(vouched).hash(value))
    except UncertainError as error:
        raise UncertainError(f"{name}: {error}") from error
    except Exception as error:  # whatever foreign code raises when it is to be pickled
        reason = error.args[0] if error.args else type(error).__name__
        raise UncertainError(f"{name} cannot be looked into: {reason}") from error


def attributes(value: Any, *, vouched: bool = False) -> dict[str, str]:
    """The digest of each attribute, but for those that no value depends on.

    Parameters
    ----------
    vouched : whether its author vouches for those that cannot be told, which are then left out.

    Raises
    ------
    UncertainError
        If one cannot be looked into; the message names it.
    """
    found = {}
    for key, each in vars(value).items():
        if _is_idle(value, key):
            continue
        try:
            found[key] = digest(each, f"{type(value).__name__}.{key}", vouched=vouched)
        except UncertainError:
            if not vouched:
                raise
    return found


def _is_idle(value: Any, key: str) -> bool:
    if isinstance(value, Problem) and key in ("cache", "elementwise_runner"):
        return True  # pymoo's: fronts that were computed, and where evaluations are made
    names = getattr(type(value), "without_effect", ())
    if not isinstance(names, tuple):  # of a text parts would be left out, too
        told = f"{type(value).__name__}.without_effect = {names!r}"
        raise UncertainError(f"{told}: expected a tuple of names")
    if key in names:
        return True
    return isinstance(getattr(type(value), key, None), cached_property)


class _Hasher(NumpyHasher):
    def __init__(self, vouched: bool) -> None:
        super().__init__()
        self._vouched = vouched
        self._seen: dict[int, tuple[int, Any]] = {}  # with the object, lest its id is reused

    def save(self, obj: Any) -> None:
        """Write it, or what says more of it than pickle would."""
        kind = type(obj)
        if kind is FunctionType or isinstance(obj, type):
            if id(obj) in self._seen:  # it may contain itself
                obj = ("seen", self._seen[id(obj)][0])
            else:
                self._seen[id(obj)] = len(self._seen), obj
                obj = list(_class(obj) if isinstance(obj, type) else _function(obj))
                obj = obj[:3] if self._vouched else obj
        elif kind is CodeType:  # by itself: others may share its constants
            parts = [getattr(obj, key) for key in _CODE]
            obj = ("code", digest(parts, "code", vouched=self._vouched))
        elif kind in _WRAPPERS:
            obj = (kind.__name__, *(getattr(obj, key) for key in _WRAPPERS[kind]))
        elif isinstance(obj, ModuleType):
            if not code_of(obj.__name__):
                raise UncertainError(f"the module {obj.__name__} has no file")
            obj = ("module", obj.__name__, code_of(obj.__name__))
        elif kind in _LOCKS:
            obj = kind.__name__
        elif kind is np.ndarray:  # a part of another one is what it shows, as its copy is
            obj = np.array(obj, order="C")
        elif kind in (set, frozenset):  # whose order says nothing
            each = [digest(item, "an item", vouched=self._vouched) for item in obj]
            obj = (kind.__name__, sorted(each))
        elif kind.__module__.startswith("numba.") and hasattr(obj, "py_func"):
            obj = ("jit", obj.py_func, obj.targetoptions)
        super().save(obj)

    def save_reduce(
        self, func: Any, args: Any, state: Any = None, *more: Any, obj: Any = None
    ) -> None:
        """Write an object; what it has kept, and the order of its attributes, say nothing of it."""
        # those with slots have two: the dictionary, and that of the slots
        parts = state if isinstance(state, tuple) else (state,)
        parts = tuple(_told(obj, each) if _names(each) else each for each in parts)
        state = parts if isinstance(state, tuple) else parts[0]
        super().save_reduce(func, args, state, *more, obj=obj)

    def _batch_setitems(self, items: Any, *more: Any) -> None:
        # joblib's, which leaves out the order of keys, takes any TypeError for that of sorting
        # them, also that of a value which cannot be pickled
        super(Hasher, self)._batch_setitems(items, *more)


def _told(value: Any, state: dict[str, Any]) -> dict[str, Any] | None:
    # none of an object without attributes, as pickle has it
    return {key: state[key] for key in sorted(state) if not _is_idle(value, key)} or None


def _names(state: Any) -> bool:
    return type(state) is dict and all(isinstance(key, str) for key in state)


def _function(function: FunctionType) -> Iterator[Any]:
    """What it does: where it comes from, or its code, what it holds, and what it names."""
    # the module whose globals it sees, which `functools.wraps` does not change
    home, code = function.__globals__.get("__name__", ""), function.__code__
    yield from ("function", home, function.__qualname__, code_of(home))
    if code_of(home) and _found(home, function.__qualname__) is function:
        return
    yield from (code, function.__defaults__, function.__kwdefaults__, vars(function))
    yield [_cell(cell) for cell in function.__closure__ or ()]
    if installed(home):
        return
    names, imports = _references(code)
    known = function.__globals__
    yield {name: known[name] for name in names if name in known}
    for module, members, level in imports:
        for found in imported(module, members, level, known.get("__package__") or ""):
            yield (found, code_of(found))


def _cell(cell: Any) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # it has none yet
        return "empty"


def _class(cls: type) -> Iterator[Any]:
    """Where it comes from, and its bases and entries as far as its file does not say them."""
    home, name = cls.__module__, cls.__qualname__
    yield from ("class", home, name, code_of(home))
    if installed(home) and _found(home, name) is cls:
        return
    yield (type(cls), cls.__bases__)
    file = source_file(home) if _found(home, name) is cls else None
    for key, entry in sorted(vars(cls).items()):
        if key in _IDLE or key.startswith(_IDLE_PREFIXES) or _of_slots(entry):
            continue
        if file is None or not _is_written(entry, f"{name}.{key}", str(file)):
            yield (key, entry)


def _of_slots(entry: Any) -> bool:
    return hasattr(entry, "__objclass__") and not callable(entry)


def _is_written(entry: Any, qualname: str, file: str) -> bool:
    """Whether an entry of a class is the method of this name in its file, or a dataclass's own."""
    wrapped = (getattr(entry, key, None) for key in ("__func__", "fget", "func", "__wrapped__"))
    function = next((each for each in wrapped if each is not None), entry)
    if not isinstance(function, FunctionType) or function.__qualname__ != qualname:
        return False
    return function.__code__.co_filename == file or (
        function.__code__.co_filename == "<string>" and qualname.endswith("__")
    )


def _references(code: CodeType) -> tuple[list[str], list[tuple[str, Any, int]]]:
    """Globals and imports, as (module, names, level), of code and of what is nested in it."""
    names, imports = set(), []
    steps = [each for each in dis.get_instructions(code) if each.opname != "EXTENDED_ARG"]
    for i, step in enumerate(steps):
        if step.opname in ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS"):
            names.add(step.argval)
        elif step.opname == "IMPORT_NAME":
            level, members = (each.argval for each in steps[i - 2 : i])
            imports.append((step.argval, members or (), level))
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            below = _references(constant)
            names.update(below[0])
            imports += below[1]
    return sorted(names), imports


def _found(home: str, qualname: str) -> Any:
    """What has this name in a module that is imported; None for nothing."""
    found: Any = sys.modules.get(home)
    for name in qualname.split("."):
        found = getattr(found, name, None)
    return found
