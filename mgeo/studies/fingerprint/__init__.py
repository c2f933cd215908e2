"""Whether a run found on disk is the run asked for: problems and algorithms by their content.

What counts is what pickle would rebuild an object from, and the code that it runs: of installed
distributions the version (and the hashes of their files, if they came from a folder or a URL), of
Python's library, NumPy and SciPy the name, of packages under development and modules beside the
script their files and those of what they import, of a script or a notebook the bytecode and all
that it names.

What cannot be known for certain (a generator, a connection, what a weak reference points to) is an
`UncertainError` that says where it is. What cannot be seen: files, services and environment
variables that are read while a problem is evaluated, code that is imported by a name made at run
time, and constants of other modules that are changed after their import. An author vouches for all
of that by an attribute ``fingerprint``, a text: it stands for the code and for what is uncertain.
"""

from __future__ import annotations

import copy
import hashlib
from typing import Any

from pymoo.core.problem import Problem

from mgeo.plugins import protocol
from mgeo.studies.fingerprint.modules import UncertainError
from mgeo.studies.fingerprint.values import Walk, has_all_options

__all__ = ["UncertainError", "fingerprint"]


def fingerprint(*parts: Any) -> str:
    """Twenty hexadecimal digits that are the same, in any process, for objects made alike.

    Of objects count their classes' code and their attributes, except those that are computed from
    others: cached properties and pymoo's caches. A problem that has ``options()`` is its class and
    these options.

    Raises
    ------
    UncertainError
        If a part may compute something else the next time, for all that can be told.
    PluginError
        If a problem's ``options()`` fails, or gives no dict, or ``fingerprint`` is no text.
    """
    digest = hashlib.sha256()
    for part in parts:
        vouched = protocol.fingerprint(part)
        found = Walk(vouched).whole(part)
        if not vouched:
            _require_repeatable(part, found)
        digest.update(found)
    return digest.hexdigest()[:20]


def _require_repeatable(part: Any, found: bytes) -> None:
    """A copy, taken apart and put together as for a worker, must come to the same."""
    if isinstance(part, Problem) and has_all_options(type(part)):
        return
    try:
        twin = copy.deepcopy(part)
    except Exception:  # whatever foreign code raises: there will be no copies then
        return
    if Walk().whole(twin) == found:
        return
    name = type(part).__qualname__
    one, other = (getattr(each, "__dict__", {}) for each in (part, twin))
    for key in one:
        if Walk().whole(one[key]) != Walk().whole(other.get(key)):
            raise UncertainError(f"{name}.{key} is another one in a copy of it")
    raise UncertainError(f"a copy of {name} is not the same")
