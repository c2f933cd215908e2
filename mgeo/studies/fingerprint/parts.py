"""Problems, algorithms and whatever else an author may give, each by what it holds and runs."""

from __future__ import annotations

import copy
import warnings
from typing import Any

from pymoo.core.algorithm import Algorithm
from pymoo.core.problem import Problem

from mgeo.plugins import protocol
from mgeo.studies.fingerprint.content import attributes, digest
from mgeo.studies.fingerprint.modules import UncertainError
from mgeo.studies.fingerprint.probe import probe_points, probed
from mgeo.studies.run import global_state


def fingerprint(*parts: Any) -> str:
    """32 hexadecimal digits that are the same, in any process, for what is made alike.

    A problem is evaluated at a few points, in a copy.

    Raises
    ------
    UncertainError
        If a part may compute something else the next time, for all that can be told.
    PluginError
        If an attribute ``fingerprint`` is no text.
    """
    return digest([_of(part) for part in parts], "fingerprint")


def _of(part: Any) -> Any:
    if not isinstance(part, Problem | Algorithm):
        return part
    kind, vouched = type(part), protocol.fingerprint(part)
    if vouched:
        return f"{kind.__module__}.{kind.__qualname__}", vouched, attributes(part, vouched=True)
    held = attributes(part)
    twin = _copy(part)
    for key, found in attributes(twin).items():
        if held.get(key) != found:
            raise UncertainError(f"{kind.__name__}.{key} is another one in a copy of it")
    if not isinstance(part, Problem):
        return digest(kind, kind.__name__), held
    points = probe_points(twin)
    with global_state(0), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        values = probed(twin, points)
        settled = attributes(twin)  # with the tables that it fills when it is first evaluated
        again = probed(twin, points)
    if again != values:
        raise UncertainError(f"{kind.__name__} gives other values when it is evaluated once more")
    # one that every evaluation changes, such as a counter, counts as it was
    counted = {key for key, found in attributes(twin).items() if settled.get(key) != found}
    held = settled | {key: held.get(key, "") for key in counted}
    names = list(getattr(part, "vars", None) or ())  # their order is that of the columns
    return digest(kind, kind.__name__), held, names, values


def _copy(part: Any) -> Any:
    try:
        return copy.deepcopy(part)
    except Exception as error:  # whatever foreign code raises
        raise UncertainError(f"{type(part).__name__} cannot be copied: {error}") from error
