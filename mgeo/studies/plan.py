"""Plan of a study, and the lock of its folder.

The plan lists the settings and software versions of a study. A study can be resumed only with an
equal plan.
"""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path
from typing import Any

import joblib
import numpy as np
from pymoo.core.algorithm import Algorithm
from pymoo.core.problem import Problem

from mgeo.benchmarks.collections import COCO_DISTRIBUTION
from mgeo.plugins import protocol
from mgeo.plugins.discovery import list_plugin_versions
from mgeo.store.atomic import encode_json, lock_folder, write_file
from mgeo.store.provenance import describe_difference, list_versions
from mgeo.store.readers import read_json

PLAN_FILE = "study.json"

_PACKAGES = ("scipy", "moocore")
_MAX_DEPTH = 4  # Levels of nested objects: algorithm, mating, crossover, parameter.
_MAX_ARRAY_SIZE = 100  # Larger arrays are described by shape and hash.


@contextmanager
def lock_study(folder: Path, plan: Mapping[str, Any], *, resume: bool) -> Iterator[None]:
    """Context manager that locks a study folder and checks the stored plan.

    A new study stores its plan, which a resumed study must match.

    Parameters
    ----------
    folder : Path
        Folder of the study, created if it does not exist.
    plan : mapping
        Names, options, parameters, seeds, budget and software versions, as JSON values.
    resume : bool
        Whether the folder may contain a study with an equal plan.

    Raises
    ------
    FileExistsError
        If the folder contains a study and `resume` is false.
    ValueError
        If the folder contains a study with another plan, or another process uses the folder.
    """
    path = folder / PLAN_FILE
    folder.mkdir(parents=True, exist_ok=True)
    with lock_folder(folder):
        check_study_folder(folder, plan, resume=resume)
        if not path.exists():
            write_file(path, encode_json(plan))
        yield


def check_study_folder(folder: Path, plan: Mapping[str, Any], *, resume: bool) -> None:
    """Raise an error if a folder contains a study that must not or cannot be resumed.

    Parameters and errors are as for `lock_study`. Stored values whose keys are not in `plan` are
    not compared: a dry run does not determine the versions, because this imports modules.
    """
    path = folder / PLAN_FILE
    if not path.exists():
        return
    if not resume:
        raise FileExistsError(
            f"{folder} contains a study: continue it with --resume (resume=True in Python), "
            "read it with read_comparison, or choose another folder"
        )
    stored, current = read_json(path), json.loads(encode_json(plan))
    compared = {key: value for key, value in stored.items() if key in current}
    if difference := describe_difference(compared, current):
        raise ValueError(
            f"{folder} contains another study: {difference}; to resume a study, its names, "
            "options, parameters, seeds, evaluations and versions must be unchanged"
        )


def describe_algorithm(algorithm: Algorithm) -> dict[str, Any]:
    """Return the class and the specific attributes of an algorithm as a JSON-serializable dict.

    Attributes that every pymoo algorithm has are omitted.
    """
    common = vars(Algorithm())
    description: dict[str, Any] = describe_value(algorithm)
    return {key: value for key, value in description.items() if key not in common}


def describe_problem(problem: Problem) -> dict[str, Any]:
    """Return the class and options of a problem as a JSON-serializable dict.

    The public attributes take the place of the options if the problem does not define options.
    """
    options = protocol.get_options(problem)
    description: dict[str, Any] = describe_value(problem, depth=1)
    return (
        description
        if options is None
        else {"class": description["class"], "options": describe_value(options)}
    )


def describe_value(value: Any, depth: int = _MAX_DEPTH) -> Any:
    """Convert any value to JSON values. Objects become dicts of their class and attributes.

    Attributes are converted recursively to `depth` levels of nested objects. Large arrays are
    replaced by their shape and hash. Objects with equal descriptions may still behave differently.
    """
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, np.ndarray):
        if value.size > _MAX_ARRAY_SIZE:
            return {"shape": list(value.shape), "hash": joblib.hash(value)}
        value = value.tolist()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, list | tuple):
        return [describe_value(item, depth) for item in value]
    if isinstance(value, Mapping):
        return {str(key): describe_value(item, depth) for key, item in value.items()}
    definition = value if hasattr(value, "__qualname__") else type(value)
    name = f"{definition.__module__}.{definition.__qualname__}"
    if definition is value or depth == 0:
        return name
    public = {k: v for k, v in getattr(value, "__dict__", {}).items() if not k.startswith("_")}
    return {"class": name} | {key: describe_value(item, depth - 1) for key, item in public.items()}


# The call reads the metadata of all installed packages.
_find_distributions = cache(packages_distributions)


def list_study_versions(*objects: Any) -> dict[str, str]:
    """Return the versions of Python, mgeo and the packages that define the given objects.

    Parameters
    ----------
    *objects
        Problem and algorithms of a study, whose packages are included.

    Returns
    -------
    dict of str to str
        Version by package name, Python first.
    """
    modules = {cls.__module__ for instance in objects for cls in type(instance).__mro__}
    distributions = _find_distributions()
    names = {name for module in modules for name in distributions.get(module.partition(".")[0], ())}
    if "mgeo.benchmarks.coco" in modules:
        names.add(COCO_DISTRIBUTION)
    versions = list_versions(*sorted({*_PACKAGES, *names}))
    return {"python": platform.python_version()} | versions | list_plugin_versions(modules)
