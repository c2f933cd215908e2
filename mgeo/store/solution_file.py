"""JSON file of one solution, in the format of its problem or in a general format."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from contextlib import suppress
from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo._typing import FloatArray
from mgeo.plugins import protocol
from mgeo.plugins.discovery import PluginError, list_plugins
from mgeo.plugins.problems import load_problem
from mgeo.validation.entries import get_entry

FORMAT_NAME = "mgeo-solution"


def build_solution_document(problem: Problem, name: str, x: FloatArray) -> dict[str, Any]:
    """Build the JSON document that stores a design with its problem and options.

    The problem can define its own format by the method ``build_document``. The general format
    consists of the name of the problem, its options and the design.

    Parameters
    ----------
    problem : Problem
        Problem of the solution.
    name : str
        Name under which the problem is installed.
    x : array, shape (n_var,)
        Design.

    Raises
    ------
    PluginError
        If ``build_document`` raises an error.
    """
    document = protocol.call_optional(problem, protocol.ProblemMixin.build_document, x.copy())
    if document is not None:
        return document
    options = protocol.get_options(problem) or {}
    return {"format": FORMAT_NAME, "problem": name, "options": options, "design": x.tolist()}


def parse_solution(
    document: Any, trusted_classes: Collection[str] = ()
) -> tuple[Problem, Mapping[str, Any], Any]:
    """Parse a solution document, and return the problem, its options and the design.

    Formats other than the general one are passed to ``parse_document`` of each installed problem.

    Parameters
    ----------
    document
        Content of a JSON file.
    trusted_classes : collection of str
        Problems ``module:Class`` that may be imported.

    Returns
    -------
    problem : Problem
        Problem of the solution.
    options : mapping
        Options of the problem.
    x : array, shape (n_var,)
        Design.

    Raises
    ------
    ValueError, TypeError
        If no installed problem recognizes the content, or its options or design are invalid.
    """
    if isinstance(document, dict) and document.get("format") == FORMAT_NAME:
        return _read_general_format(document, trusted_classes)
    if (result := _read_problem_format(document)) is not None:
        name, options, x = result
        return load_problem(name, options), options, x
    raise ValueError("expected a run folder, or a solution file of an installed problem")


def _read_problem_format(document: Any) -> tuple[str, Mapping[str, Any], Any] | None:
    """Parse a document in the format of an installed problem.

    Return the problem name, the options and the design, or None if no problem recognizes the
    document.
    """
    for plugin in list_plugins() if isinstance(document, dict) else ():
        with suppress(PluginError):  # A plugin that cannot be loaded is skipped.
            reader = getattr(plugin.load(), "parse_document", None)
            if reader is not None and (result := reader(document)) is not None:
                return plugin.name, *result
    return None


def _read_general_format(
    document: Mapping[str, Any], trusted_classes: Collection[str]
) -> tuple[Problem, Mapping[str, Any], FloatArray]:
    options = get_entry(document, "options", dict[str, Any])
    name = get_entry(document, "problem", str)
    problem = load_problem(name, options, trusted_classes=trusted_classes)
    x = np.array(get_entry(document, "design", list[float]), dtype=float)
    if x.shape != (problem.n_var,):
        raise ValueError(f"design has {len(x)} numbers: expected {problem.n_var}")
    return problem, options, x
