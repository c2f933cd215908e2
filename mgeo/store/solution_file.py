"""One solution as a JSON file, in the form of its problem, or by the name of that."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from contextlib import suppress
from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray
from mgeo.plugins import protocol
from mgeo.plugins.discovery import PluginError, installed_plugins
from mgeo.plugins.problems import load_problem
from mgeo.validation.entries import entry

FORMAT = "mgeo-solution"


def solution_document(problem: Problem, name: str, x: FloatArray) -> dict[str, Any]:
    """What a file says of a solution, shape (n_var,), of the problem that is installed as `name`.

    It is what the problem's ``document_of(x)`` gives, or else its name, options and the design as
    numbers.

    Raises
    ------
    PluginError
        If ``document_of`` raises.
    """
    found = protocol.ask(problem, protocol.ProblemMixin.document_of, x.copy())
    if found is not None:
        return found
    options = protocol.options(problem) or {}
    return {"format": FORMAT, "problem": name, "options": options, "design": x.tolist()}


def solution_of(
    document: Any, named: Collection[str] = ()
) -> tuple[Problem, Mapping[str, Any], Any]:
    """Problem, options and solution of a file, by the ``solution_of`` of an installed problem.

    Parameters
    ----------
    named
        Problems that may be imported, ``module:Class``.

    Raises
    ------
    ValueError, TypeError
        If no installed problem knows it, or the problem refuses what is in it.
    """
    if isinstance(document, dict) and document.get("format") == FORMAT:
        return _own(document, named)
    if (found := _known(document)) is not None:
        name, options, x = found
        return load_problem(name, options), options, x
    raise ValueError("expected a run folder, or a solution's file of an installed problem")


def _known(document: Any) -> tuple[str, Mapping[str, Any], Any] | None:
    """Name, options and solution of the first installed problem whose file it is."""
    for plugin in installed_plugins() if isinstance(document, dict) else ():
        with suppress(PluginError):  # one that does not load knows nothing of it
            known = getattr(plugin.load(), "solution_of", None)
            if known is not None and (found := known(document)) is not None:
                return plugin.name, *found
    return None


def _own(
    document: Mapping[str, Any], named: Collection[str]
) -> tuple[Problem, Mapping[str, Any], FloatArray]:
    options = entry(document, "options", dict[str, Any])
    name = entry(document, "problem", str)
    problem = load_problem(name, options, named=named)
    x = np.array(entry(document, "design", list[float]), dtype=float)
    if x.shape != (problem.n_var,):
        raise ValueError(f"design of {len(x)} numbers: expected {problem.n_var}")
    return problem, options, x
