"""Plan of a study, which identifies an interrupted study, and the lock of its folder."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib.metadata import packages_distributions, version
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
from mgeo.store.provenance import describe_difference
from mgeo.store.readers import read_json

PLAN_FILE = "study.json"

_CORE_PACKAGES = ("mgeo", "pymoo", "numpy", "scipy", "moocore")
_MAX_DEPTH = 4  # levels of nested objects: algorithm, mating, crossover, parameter
_MAX_ARRAY_SIZE = 100  # size of an array up to which its values are listed


@contextmanager
def lock_study(folder: Path, plan: Mapping[str, Any], *, resume: bool) -> Iterator[None]:
    """Lock a folder for one study and record the plan of the study there.

    Parameters
    ----------
    folder : folder of the study, created if it does not exist.
    plan : names, options, parameters, seeds, budget and versions, as JSON values.
    resume : whether to continue a study of an equal plan.

    Raises
    ------
    FileExistsError
        If the folder holds a study and `resume` is false.
    ValueError
        If the folder holds a study of another plan, or another process uses the folder.
    """
    path, content = folder / PLAN_FILE, encode_json(plan)
    folder.mkdir(parents=True, exist_ok=True)
    with lock_folder(folder):
        if not path.exists():
            write_file(path, content)
        elif not resume:
            raise FileExistsError(
                f"{folder} holds a study: --resume (resume=True in Python) continues it, "
                "read_comparison reads it; expected one of these, or another folder"
            )
        elif text := describe_difference(read_json(path), json.loads(content)):
            raise ValueError(
                f"{folder} holds another study: {text}; to resume, expected the same names, "
                "options, parameters, seeds, evaluations and versions"
            )
        yield


def describe_algorithm(algorithm: Algorithm) -> dict[str, Any]:
    """Return the class and the public attributes that distinguish an algorithm, as JSON values."""
    common = vars(Algorithm())
    description: dict[str, Any] = describe_value(algorithm)
    return {key: each for key, each in description.items() if key not in common}


def describe_problem(problem: Problem) -> dict[str, Any]:
    """Return the class and options of a problem as JSON values, or its public attributes."""
    options = protocol.get_options(problem)
    description: dict[str, Any] = describe_value(problem, depth=1)
    return (
        description
        if options is None
        else {"class": description["class"], "options": describe_value(options)}
    )


def describe_value(value: Any, depth: int = _MAX_DEPTH) -> Any:
    """Return JSON values that identify an object by its class and public attributes.

    Attributes are described recursively to `depth` levels. Equal descriptions do not prove equal
    behavior.
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
        return [describe_value(each, depth) for each in value]
    if isinstance(value, Mapping):
        return {str(key): describe_value(each, depth) for key, each in value.items()}
    named = value if hasattr(value, "__qualname__") else type(value)
    name = f"{named.__module__}.{named.__qualname__}"
    if named is value or depth == 0:
        return name
    public = {k: v for k, v in getattr(value, "__dict__", {}).items() if not k.startswith("_")}
    return {"class": name} | {key: describe_value(each, depth - 1) for key, each in public.items()}


_distributions = cache(packages_distributions)  # reads the metadata of all packages


def list_study_versions(*objects: Any) -> dict[str, str]:
    """Return the versions of Python, mgeo's dependencies, and the packages that define `objects`."""
    modules = {cls.__module__ for part in objects for cls in type(part).__mro__}
    owners = _distributions()
    names = {name for module in modules for name in owners.get(module.partition(".")[0], ())}
    if "mgeo.benchmarks.coco" in modules:
        names.add(COCO_DISTRIBUTION)
    versions = {name: version(name) for name in sorted({*_CORE_PACKAGES, *names})}
    return {"python": platform.python_version()} | versions | list_plugin_versions(modules)
