"""Functions and classes by what they do: their bytecode and all that it names, or a version."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from types import CodeType, FunctionType, ModuleType
from typing import TYPE_CHECKING, Any

from mgeo.studies.fingerprint.digest import mix
from mgeo.studies.fingerprint.names import references
from mgeo.studies.fingerprint.origins import installed, source_file
from mgeo.studies.fingerprint.sources import imported, sources

if TYPE_CHECKING:
    from mgeo.studies.fingerprint.values import Walk

_COUNTS = ("co_argcount", "co_posonlyargcount", "co_kwonlyargcount", "co_flags")
_NAMES = ("co_names", "co_varnames", "co_freevars", "co_cellvars")
#: Entries of a class that say nothing of what it computes.
_IDLE = {
    "__abstractmethods__", "__annotations__", "__dict__", "__doc__", "__firstlineno__",
    "__match_args__", "__module__", "__orig_bases__", "__parameters__", "__static_attributes__",
    "__type_params__", "__weakref__", "_abc_impl", "_value2member_map_",
}  # fmt: skip
_IDLE_PREFIXES = ("__annotat", "__dataclass_")


def function(walk: Walk, value: FunctionType) -> bytes:
    """What a function does: its code, what it holds, and what it names."""
    home = _home(value)
    held = [
        walk(value.__defaults__, " (its defaults)"),
        walk(value.__kwdefaults__, " (its defaults)"),
        *(
            walk(cell, f" (its variable {name})")
            for name, cell in zip(value.__code__.co_freevars, value.__closure__ or (), strict=True)
        ),
    ]
    if walk.vouched:
        return mix("function", value.__qualname__, *held)
    own = walk(value.__code__)
    if owner := installed(home):
        return mix("function", owner, home, value.__qualname__, own, *held)
    named = [digest for found in _named(walk, value, home) for digest in found]
    return mix("function", own, walk(vars(value)), *held, *named, _files(walk, home))


def class_(walk: Walk, value: type) -> bytes:
    """A class by its entries and its bases, and by all files of its module."""
    home = value.__module__
    owner = installed(home)
    if owner and _resolved(home, value.__qualname__) is value:
        return mix("class", owner, home, value.__qualname__)
    entries = (
        part
        for key, entry in sorted(vars(value).items())
        if key not in _IDLE and not key.startswith(_IDLE_PREFIXES)
        if not (walk.vouched and hasattr(entry, "__get__"))  # a method, a property
        for part in (walk(key), walk(entry, f".{key}"))
    )
    above = (walk(each, f" (its base {each.__qualname__})") for each in value.__bases__)
    made = walk(type(value), " (its metaclass)")
    return mix("class", owner, value.__qualname__, made, *above, *entries, _files(walk, home))


def instructions(walk: Walk, value: CodeType) -> bytes:
    """Bytecode, wherever it stands in a file."""
    names = [",".join(getattr(value, key)) for key in _NAMES]
    counts = [str(getattr(value, key)) for key in _COUNTS]
    constants = (walk(constant) for constant in value.co_consts)
    table = value.co_exceptiontable
    return mix("code", value.co_code, table, *counts, *names, *constants)


def builtin(walk: Walk, value: Any) -> bytes:
    """A function or an attribute that is compiled, by its name and what it is bound to."""
    cls = getattr(value, "__objclass__", None)
    home = value.__module__ if cls is None else cls.__module__
    if cls is not None:
        return mix(
            "attribute", installed(home), _files(walk, home), cls.__qualname__, value.__name__
        )
    if home and _resolved(home, value.__qualname__) is value:
        return mix("builtin", value.__qualname__, module(walk, home))
    return mix("builtin", value.__qualname__, walk(value.__self__, " (what it is bound to)"))


def module(walk: Walk, name: str) -> bytes:
    """A module by its version, or by its files and those that it imports."""
    if owner := installed(name):
        return mix("module", owner, name)
    if not (found := _files(walk, name)):
        return walk.uncertain(f"is the module {name}, which has no file")
    return mix("module", name, found)


def _named(walk: Walk, value: FunctionType, home: str) -> Iterator[tuple[str, bytes]]:
    """Names that a function's code refers to, with digests of what they stand for."""
    found = references(value.__code__)
    names = value.__globals__
    for chain in found.dotted:
        if chain[0] not in names:  # one of Python's own, or never defined
            continue
        thing, reached = names[chain[0]], chain[0]
        for attribute in chain[1:]:
            if not isinstance(thing, ModuleType) or installed(thing.__name__):
                break
            yield reached, _files(walk, thing.__name__)
            if not hasattr(thing, attribute):
                break
            thing, reached = getattr(thing, attribute), f"{reached}.{attribute}"
        yield reached, _referred(walk, thing, home, f" (global {reached})")
    for target, members, level in found.imports:
        package = names.get("__package__") or ""
        for name in imported(target, list(members), level, package) if members else (target,):
            yield name, mix(installed(name), _files(walk, name))


def _referred(walk: Walk, value: Any, home: str, step: str) -> bytes:
    """What a global stands for; the files of another module say all of what that defines."""
    if isinstance(value, FunctionType | type):
        there = _home(value)
        if there != home and source_file(there) and _resolved(there, value.__qualname__) is value:
            return mix("defined", there, value.__qualname__, _files(walk, there))
    return walk(value, step)


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


def _files(walk: Walk, home: str) -> bytes:
    return b"" if walk.vouched or source_file(home) is None else sources(home)
