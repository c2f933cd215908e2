"""Identity of a problem and versions of the software, as JSON-serializable values."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from mgeo.benchmarks.collections import is_benchmark, list_distributions
from mgeo.evaluation.individuals import get_choice_options
from mgeo.plugins import protocol
from mgeo.plugins.discovery import find_plugin
from mgeo.plugins.problems import is_class_path


def identify_problem(problem: Problem) -> dict[str, Any]:
    """Return a dict that identifies a problem by its class, sizes, bounds and options."""
    variables = getattr(problem, "vars", None) or {}
    choices = get_choice_options(problem)
    data = {
        "class": type(problem).__name__,
        "n_var": problem.n_var,
        "n_obj": problem.n_obj,
        "n_ieq_constr": problem.n_ieq_constr,
        "n_eq_constr": problem.n_eq_constr,
        "vars": {key: type(variable).__name__ for key, variable in variables.items()},
        **({"choices": choices} if choices else {}),
        "xl": _convert_bound_to_list(problem.xl),
        "xu": _convert_bound_to_list(problem.xu),
        "options": protocol.get_options(problem),
    }
    read_back: dict[str, Any] = json.loads(json.dumps(data, default=str))
    return read_back


def _convert_bound_to_list(bound: Any) -> Any:
    return bound.tolist() if isinstance(bound, np.ndarray) else bound


def describe_difference(expected: Any, actual: Any, name: str = "") -> str:
    """Describe the first difference between two JSON values, or return an empty string.

    Parameters
    ----------
    expected, actual
        JSON values.
    name : str
        Name of the values in the text.
    """
    if isinstance(expected, Mapping) and isinstance(actual, Mapping):
        for key in [*expected, *(key for key in actual if key not in expected)]:
            full_name = f"{name}.{key}" if name else key
            if text := describe_difference(expected.get(key), actual.get(key), full_name):
                return text
        return ""
    return "" if expected == actual else f"{name} = {actual!r}, expected {expected!r}"


def list_versions(*extra_distributions: str) -> dict[str, str]:
    """Return a dict of the installed versions of mgeo, pymoo, numpy and the given packages."""
    return {name: version(name) for name in ("mgeo", "pymoo", "numpy", *extra_distributions)}


def list_problem_versions(problem: str) -> dict[str, str]:
    """Return the versions of Python and of all packages that affect the runs of a problem.

    Parameters
    ----------
    problem : str
        Name of the problem.

    Returns
    -------
    dict of str to str
        Versions of Python, mgeo, pymoo, numpy and the package that provides the problem.
    """
    if is_benchmark(problem):
        names = list_distributions(problem)
    else:
        names = [] if is_class_path(problem) else [find_plugin(problem).distribution]
    return {"python": platform.python_version(), **list_versions(*names)}
