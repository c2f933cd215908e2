"""Whether a run found on disk is the run asked for: problems and algorithms by their content.

What counts is what an object would be rebuilt from by pickle, and the code that it runs, by which
module that comes from:

- a distribution that is installed: its version, and if it came from a folder or a URL the hashes of
  its files; of Python's library, NumPy and SciPy the name alone, since their versions are kept with
  each run;
- a package under development, or a module beside the script: its files, and those of what it
  imports;
- a script or a notebook, and besides every function and class of which the object is made: the
  bytecode, defaults, the values that closures hold, class attributes, and the globals that are
  named, with the functions and classes of the same module among them.

What cannot be told for certain (a generator, a connection, what a weak reference points to) is an
`UncertainError` that says where it is. What cannot be seen: files, services and environment
variables that are read while a problem is evaluated, code that is imported by a name made at run
time, and constants of other modules that are changed after their import. An author vouches for all
of that by an attribute ``fingerprint``, a text: it stands for the code and for what cannot be told.
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
