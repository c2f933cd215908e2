"""Functions and classes taken apart: their code and all that it names, or where it comes from."""

from __future__ import annotations

import dis
import sys
from collections.abc import Collection, Iterator
from functools import cached_property, lru_cache
from types import (
    BuiltinFunctionType,
    CellType,
    ClassMethodDescriptorType,
    CodeType,
    FunctionType,
    GetSetDescriptorType,
    MemberDescriptorType,
    MethodDescriptorType,
    MethodType,
    ModuleType,
    WrapperDescriptorType,
)
from typing import Any, NamedTuple

from mgeo.studies.fingerprint.modules import code_of, imported, installed, source_file

_OF_A_CLASS = ("__objclass__", "__name__")
#: What pickle cannot take apart, or knows by its name only: the attributes that say what it does.
ATTRIBUTES: dict[type, tuple[str, ...]] = {
    CodeType: (
        "co_code", "co_exceptiontable", "co_consts", "co_names", "co_varnames", "co_freevars",
        "co_cellvars", "co_argcount", "co_posonlyargcount", "co_kwonlyargcount", "co_flags",
    ),
    MethodType: ("__func__", "__self__"),
    ClassMethodDescriptorType: _OF_A_CLASS,
    GetSetDescriptorType: _OF_A_CLASS,
    MemberDescriptorType: _OF_A_CLASS,
    MethodDescriptorType: _OF_A_CLASS,
    WrapperDescriptorType: _OF_A_CLASS,
    property: ("fget", "fset", "fdel"),
    cached_property: ("func",),
    staticmethod: ("__wrapped__",),
    classmethod: ("__wrapped__",),
    type(lru_cache(len)): ("__wrapped__",),
}  # fmt: skip
#: Entries of a class that say nothing of what it computes.
_IDLE = {
    "__abstractmethods__", "__annotations__", "__dict__", "__doc__", "__firstlineno__",
    "__match_args__", "__module__", "__orig_bases__", "__parameters__", "__static_attributes__",
    "__type_params__", "__weakref__", "_abc_impl", "_value2member_map_",
}  # fmt: skip
_IDLE_PREFIXES = ("__annotat", "__dataclass_")
_GLOBAL = ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS")


class Part(NamedTuple):
    """A value within another one, and how one gets there."""

    value: Any
    step: str = ""


class Unknown(NamedTuple):
    """What cannot be told for certain, and why."""

    reason: str


Parts = Iterator[str | bytes | Part | Unknown]


def function_parts(value: FunctionType, vouched: bool) -> Parts:
    """What a function does: its code, what it holds, and what it names."""
    home = _home(value)
    yield from ("function", home, value.__qualname__)
    yield Part(value.__defaults__, " (its defaults)")
    yield Part(value.__kwdefaults__, " (its defaults)")
    for name, cell in zip(value.__code__.co_freevars, value.__closure__ or (), strict=True):
        if cell != CellType():
            yield from (name, Part(cell.cell_contents, f" (its variable {name})"))
    if vouched:
        return
    yield from (Part(value.__code__), code_of(home))
    if installed(home):
        return
    yield Part(vars(value))
    names, attributes, imports = _references(value.__code__)
    for name in names:
        if name in value.__globals__:  # not one of Python's own, or never defined
            yield from _referred(value.__globals__[name], name, home, attributes)
    for module, members, level in imports:
        for found in imported(module, members, level, value.__globals__.get("__package__") or ""):
            yield from (found, code_of(found))


def class_parts(value: type, vouched: bool) -> Parts:
    """A class by its entries and its bases, and by the code of its module."""
    home, name = value.__module__, value.__qualname__
    yield from ("class", home, name, "" if vouched else code_of(home))
    if installed(home) and _resolved(home, name) is value:
        return
    yield Part(type(value), " (its metaclass)")
    for base in value.__bases__:
        yield Part(base, f" (its base {base.__qualname__})")
    for key, entry in sorted(vars(value).items()):
        idle = key in _IDLE or key.startswith(_IDLE_PREFIXES)
        if not idle and not (vouched and hasattr(entry, "__get__")):  # a method, a property
            yield from (key, Part(entry, f".{key}"))


def module_parts(value: ModuleType, vouched: bool) -> Parts:
    """A module by its version, or by its files and those that it imports."""
    name = value.__name__
    yield from ("module", name, "" if vouched else code_of(name))
    if not code_of(name):
        yield Unknown(f"is the module {name}, which has no file")


def builtin_parts(value: BuiltinFunctionType) -> Parts:
    """A compiled function by its name, and its module or what it is bound to."""
    home = value.__module__ or ""
    yield from ("builtin", value.__name__)
    if _resolved(home, value.__name__) is value:
        yield Part(sys.modules[home])
    elif value.__self__ is not None:
        yield Part(value.__self__, " (what it is bound to)")
    else:
        yield Unknown(f"is the function {value.__name__}, which is in no module")


def _referred(
    value: Any, name: str, home: str, attributes: Collection[str], seen: tuple[Any, ...] = ()
) -> Parts:
    """What a global stands for; of a module under development also what it may be asked for."""
    yield name
    if isinstance(value, FunctionType | type):
        there = _home(value)
        if there != home and source_file(there) and _resolved(there, value.__qualname__) is value:
            # the files of another module say all of what it defines
            yield from (there, value.__qualname__, code_of(there))
            return
    yield Part(value, f" (global {name})")
    if isinstance(value, ModuleType) and not installed(value.__name__) and value not in seen:
        for key in sorted(vars(value).keys() & attributes):
            below = f"{name}.{key}"
            yield from _referred(vars(value)[key], below, home, attributes, (*seen, value))


@lru_cache(maxsize=4096)
def _references(code: CodeType) -> tuple[list[str], set[str], list[tuple[str, Any, int]]]:
    """Globals, attributes and imports, as (module, names, level), of code and what is nested."""
    names: set[str] = set()
    attributes = set(code.co_names)
    imports = []
    operations = [each for each in dis.get_instructions(code) if each.opname != "EXTENDED_ARG"]
    for i, operation in enumerate(operations):
        if operation.opname in _GLOBAL:
            names.add(operation.argval)
        elif operation.opname == "IMPORT_NAME":
            level, members = (each.argval for each in operations[i - 2 : i])
            imports.append((operation.argval, members or (), level))
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            below = _references(constant)
            names.update(below[0])
            attributes |= below[1]
            imports += below[2]
    return sorted(names), attributes, imports


def _home(value: FunctionType | type) -> str:
    """The module whose globals it sees, which `functools.wraps` does not change."""
    if isinstance(value, type):
        return value.__module__
    return str(value.__globals__.get("__name__", ""))


def _resolved(home: str, qualname: str) -> Any:
    found: Any = sys.modules.get(home)
    for name in qualname.split("."):
        found = getattr(found, name, None)
    return found
