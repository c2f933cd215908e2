"""What a piece of bytecode refers to outside itself."""

from __future__ import annotations

import dis
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from types import CodeType

_GLOBAL = ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS")
_ATTRIBUTE = ("LOAD_ATTR", "LOAD_METHOD")


@dataclass(frozen=True)
class References:
    """Globals, each with the attributes asked of it, and imports: (module, names, level)."""

    dotted: tuple[tuple[str, ...], ...]
    imports: tuple[tuple[str, tuple[str, ...], int], ...]


@lru_cache(maxsize=4096)
def references(code: CodeType) -> References:
    """Of a function's code and of all code nested in it, sorted."""
    dotted = {tuple(chain) for one in _all(code) for chain in _chains(one)}
    imports = {found for one in _all(code) for found in _imports(one)}
    return References(tuple(sorted(dotted)), tuple(sorted(imports)))


def _all(code: CodeType) -> Iterator[CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _all(constant)


def _instructions(code: CodeType) -> Iterator[dis.Instruction]:
    return (each for each in dis.get_instructions(code) if each.opname != "EXTENDED_ARG")


def _chains(code: CodeType) -> Iterator[list[str]]:
    chain: list[str] = []
    for instruction in _instructions(code):
        if chain and instruction.opname in _ATTRIBUTE:
            chain.append(instruction.argval)
            continue
        if chain:
            yield chain
        chain = [instruction.argval] if instruction.opname in _GLOBAL else []
    if chain:
        yield chain


def _imports(code: CodeType) -> Iterator[tuple[str, tuple[str, ...], int]]:
    constants: list[object] = []
    for instruction in _instructions(code):
        if instruction.opname == "IMPORT_NAME":
            level, names = constants[-2:]
            assert isinstance(level, int)
            yield instruction.argval, names if isinstance(names, tuple) else (), level
        constants = [*constants, instruction.argval][-2:]
