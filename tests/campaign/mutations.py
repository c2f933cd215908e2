"""Ways to spoil bytes, texts, trees of values, tables and arrays."""

from __future__ import annotations

import copy
import io
import struct
import zipfile
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .harness import Box

ESCAPES = "\x1b]0;owned\x07\x1b[2J\x1b[31m"
NASTY: list[Any] = [
    None, True, False, 0, -1, 1, 2.5, 1e308, -1e308, 10**30, -(10**30), 2**63, float("nan"),
    float("inf"), -float("inf"), "", " ", "x", "5", "nan", ESCAPES, "two\nlines", "../../x",
    "/etc/passwd", "a\x00b", "\u2028", "<script>alert(1)</script>", "\ud800", "é" * 300,
    "x" * 20_000,
    [], {}, [[]], [None], {"": None}, [1, 2, 3], [0.5] * 12, ["a", "a"], {"a": {"b": {"c": 1}}},
    list(range(1000)),
]  # fmt: skip


def nasty(box: Box) -> Any:
    """A value where another one belongs."""
    return copy.deepcopy(box.pick(NASTY))


def spoiled_bytes(box: Box, content: bytes) -> bytes:
    """Cut, flipped, doubled, emptied, ..."""
    changes = {
        "cut": lambda: content[: _at(box, content)],
        "without its beginning": lambda: content[_at(box, content) :],
        "flipped": lambda: _flipped(box, content),
        "a piece removed": lambda: _replaced(box, content, b""),
        "a piece of noise": lambda: _replaced(box, content, box.rng.bytes(8)),
        "a piece of zeros": lambda: _replaced(box, content, bytes(16)),
        "a piece of escapes": lambda: _replaced(box, content, ESCAPES.encode()),
        "a line removed": lambda: _lines(box, content, keep=False),
        "a line doubled": lambda: _lines(box, content, keep=True),
        "empty": lambda: b"",
        "one byte": lambda: b"\n",
        "noise": lambda: box.rng.bytes(200),
        "zeros": lambda: bytes(len(content)),
        "doubled": lambda: content * 2,
        "with more after it": lambda: content + b"\n,\x1b[31m{",
        "in UTF-16": lambda: content.decode("utf-8", "replace").encode("utf-16"),
        "with a byte-order mark": lambda: b"\xef\xbb\xbf" + content,
        "of other line ends": lambda: content.replace(b"\n", b"\r"),
        "a pickle": lambda: b"\x80\x04\x95\x1b\x00\x00\x00\x00\x00\x00\x00\x8c\x02os\x94.",
        "nested deeply": lambda: b"[" * 100_000,
        "a huge number": lambda: _replaced(box, content, b"9" * 5_000),
    }
    return _one(box, changes)


def spoiled_tree(box: Box, tree: Any) -> Any:
    """The tree with something else at a few places: nearly always one."""
    spoiled = copy.deepcopy(tree)
    for _ in range(1 if box.chance(0.8) else 3):
        paths = list(_paths(spoiled))
        if not paths:
            return nasty(box)
        parent, key = box.pick(paths)
        changes: dict[str, Callable[[], Any]] = {
            "something else": lambda p=parent, k=key: p.__setitem__(k, nasty(box)),
            "removed": lambda p=parent, k=key: p.__delitem__(k),
            "in a list": lambda p=parent, k=key: p.__setitem__(k, [p[k]]),
            "as text": lambda p=parent, k=key: p.__setitem__(k, str(p[k])),
        }
        if isinstance(parent, dict):
            changes["another name"] = lambda p=parent, k=key: p.__setitem__(
                box.pick(["unknown", ESCAPES, "", k + "x", k.upper()]), p.pop(k)
            )
        else:
            changes["twice"] = lambda p=parent, k=key: p.insert(k, copy.deepcopy(p[k]))
        box.note(f"at {key!r}:")
        _one(box, changes, weights=[4.0] + [1.0] * (len(changes) - 1))
    return spoiled


def spoiled_table(box: Box, content: bytes) -> bytes:
    """A CSV file with another cell, column or row."""
    rows = [line.split(",") for line in content.decode().splitlines()]
    i = int(box.rng.integers(len(rows)))
    j = int(box.rng.integers(len(rows[i])))
    cell = box.pick(
        ["", "nan", "inf", "-inf", "1e999", "1_0", "١", "x", "=1+1", ESCAPES, '"', '"a\nb"', "None",
         "1e-400", "-0.0", "9" * 400, "0x10", "1 ", "True", "a\x00b", '<img src=x onerror="a()">']
    )  # fmt: skip
    changes: dict[str, Callable[[], object]] = {
        f"{cell[:30]!r} in row {i}": lambda: rows[i].__setitem__(j, cell),
        "another name of a column": lambda: rows[0].__setitem__(
            j % len(rows[0]), box.pick(["", "x1", ESCAPES, "f1", "<b>"])
        ),
        f"row {i} short": lambda: rows[i].__delitem__(j),
        f"row {i} long": lambda: rows[i].append("1"),
        f"row {i} twice": lambda: rows.insert(i, list(rows[i])),
        f"row {i} removed": lambda: rows.__delitem__(i),
        "a column removed": lambda: [row.__delitem__(-1) for row in rows],
        "a column more": lambda: [row.append(str(k)) for k, row in enumerate(rows)],
        "no rows": lambda: rows.__delitem__(slice(1, None)),
        "columns in another order": lambda: [row.reverse() for row in rows],
    }
    _one(box, changes, weights=[6.0] + [1.0] * (len(changes) - 1))
    return "".join(",".join(row) + "\n" for row in rows).encode()


def spoiled_arrays(box: Box, arrays: Mapping[str, np.ndarray]) -> bytes:
    """An .npz archive in which one array, or the archive itself, is not as it should be."""
    changed = dict(arrays)
    name = box.pick(list(arrays))
    array = arrays[name]
    with np.errstate(over="ignore"):  # a number may be more than it holds
        coarse = array.astype(np.float16)
    others: list[Any] = [
        np.array(np.nan), np.array([]), np.array([[[]]]), np.array(10**18), np.array(-1),
        np.array(["x"]), np.array([b"x"]), np.array([1 + 2j]), np.array([True]), np.zeros((3, 3)),
        np.array([np.inf]), np.array(["2020"], dtype="M8[D]"), np.zeros(2, dtype=[("a", "i4")]),
        array.astype(str), array[..., None], array.ravel()[:1], array.ravel()[:-1],
        np.concatenate([array.ravel(), array.ravel()]), np.full(array.shape, np.nan),
        np.full(array.shape, -(2**62)), np.full(array.shape, 1e300), coarse,
    ]  # fmt: skip
    changes: dict[str, Callable[[], bytes]] = {
        f"another {name}": lambda: _npz(changed | {name: box.pick(others)}),
        f"no {name}": lambda: _npz({key: changed[key] for key in changed if key != name}),
        "one more": lambda: _npz(changed | {box.pick(["x", "../x", "file"]): np.ones(2)}),
        "a pickle in it": lambda: _npz(changed | {name: np.array([{}, None], dtype=object)}),
        f"{name} of a size it has not": lambda: _zip(changed | {name: _lying_header(box)}),
        f"{name} is no array": lambda: _zip(changed | {name: b"text"}),
        "a damaged zip": lambda: spoiled_bytes(box, _npz(changed)),
        "a bare array": lambda: _npy(array),
    }
    return _one(box, changes, weights=[6.0] + [1.0] * (len(changes) - 1))


def _one(box: Box, changes: Mapping[str, Callable[[], Any]], weights: Any = None) -> Any:
    p = None if weights is None else np.array(weights) / np.sum(weights)
    name = list(changes)[int(box.rng.choice(len(changes), p=p))]
    box.note(name)
    return changes[name]()


def _paths(tree: Any) -> Any:
    entries = tree.items() if isinstance(tree, dict) else enumerate(tree)
    for key, value in list(entries):
        yield tree, key
        if isinstance(value, dict | list):
            yield from _paths(value)


def _at(box: Box, content: bytes) -> int:
    return int(box.rng.integers(len(content) + 1))


def _flipped(box: Box, content: bytes) -> bytes:
    changed = bytearray(content or b"\0")
    for _ in range(int(box.rng.integers(1, 9))):
        changed[int(box.rng.integers(len(changed)))] ^= 1 << int(box.rng.integers(8))
    return bytes(changed)


def _replaced(box: Box, content: bytes, piece: bytes) -> bytes:
    start = _at(box, content)
    return content[:start] + piece + content[start + int(box.rng.integers(1, 40)) :]


def _lines(box: Box, content: bytes, keep: bool) -> bytes:
    lines = content.splitlines(keepends=True) or [b""]
    i = int(box.rng.integers(len(lines)))
    return b"".join(lines[:i] + [lines[i]] * (2 if keep else 0) + lines[i + 1 :])


def _npy(array: np.ndarray) -> bytes:
    content = io.BytesIO()
    np.save(content, array)
    return content.getvalue()


def _npz(arrays: Mapping[str, np.ndarray]) -> bytes:
    return _zip({name: _npy(array) for name, array in arrays.items()})


def _zip(entries: Mapping[str, Any]) -> bytes:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for name, entry in entries.items():
            archive.writestr(f"{name}.npy", entry if isinstance(entry, bytes) else _npy(entry))
    return content.getvalue()


def _lying_header(box: Box) -> bytes:
    shape = box.pick(
        ["(1000000000000000,)", "(-1,)", "(99999999999, 9999)", "(2, 'x')", "__import__('os')"]
    )
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + bytes(16)
