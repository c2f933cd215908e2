"""Plan of a study, by which an interrupted study is recognized, and the folder that holds it."""

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

from mgeo.benchmarks.collections import COCO
from mgeo.plugins import protocol
from mgeo.plugins.discovery import plugin_versions
from mgeo.store.atomic import lock, to_json, write_file
from mgeo.store.provenance import difference
from mgeo.store.reading import read_json

PLAN = "study.json"

_ALWAYS = ("mgeo", "pymoo", "numpy", "scipy", "moocore")
_DEPTH = 4  # levels of objects: algorithm, mating, crossover, its parameter
_LONGEST = 100  # values of an array that is written out


@contextmanager
def claim(folder: Path, plan: Mapping[str, Any], *, resume: bool) -> Iterator[None]:
    """Hold the lock of a folder for one study, whose plan is recorded there.

    Parameters
    ----------
    plan : names, options, parameters, seeds, budget and versions, as JSON values.
    resume : whether to continue a study of the same plan.

    Raises
    ------
    FileExistsError
        If the folder holds a study and `resume` is false.
    ValueError
        If the plans differ, with the first difference, or another process uses the folder.
    """
    path, content = folder / PLAN, to_json(plan)
    folder.mkdir(parents=True, exist_ok=True)
    with lock(folder):
        if not path.exists():
            write_file(path, content)
        elif not resume:
            raise FileExistsError(
                f"{folder} holds a study: --resume (resume=True in Python) continues it, "
                "read_comparison reads it; expected one of these, or another folder"
            )
        elif text := difference(read_json(path), json.loads(content)):
            raise ValueError(
                f"{folder} holds another study: {text}; to resume, expected the same names, "
                "options, parameters, seeds, evaluations and versions"
            )
        yield


def describe_algorithm(algorithm: Algorithm) -> dict[str, Any]:
    """Return class and public attributes of an algorithm, without those of every algorithm."""
    every = vars(Algorithm())
    found: dict[str, Any] = describe(algorithm)
    return {key: each for key, each in found.items() if key not in every}


def describe_problem(problem: Problem) -> dict[str, Any]:
    """Return class and options of a problem; its public attributes where it has no options."""
    options = protocol.options(problem)
    found: dict[str, Any] = describe(problem, depth=1)
    return found if options is None else {"class": found["class"], "options": describe(options)}


def describe(value: Any, depth: int = _DEPTH) -> Any:
    """Return JSON values that name an object and its public attributes, to some depth.

    Equal descriptions do not prove equal behavior: they show the changes of a study that its
    author would call another study.
    """
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, np.ndarray):
        if value.size > _LONGEST:
            return {"shape": list(value.shape), "hash": joblib.hash(value)}
        value = value.tolist()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, list | tuple):
        return [describe(each, depth) for each in value]
    if isinstance(value, Mapping):
        return {str(key): describe(each, depth) for key, each in value.items()}
    named = value if hasattr(value, "__qualname__") else type(value)
    name = f"{named.__module__}.{named.__qualname__}"
    if named is value or depth == 0:
        return name
    public = {k: v for k, v in getattr(value, "__dict__", {}).items() if not k.startswith("_")}
    return {"class": name} | {key: describe(each, depth - 1) for key, each in public.items()}


_distributions = cache(packages_distributions)  # reads the metadata of all packages


def installed_versions(*parts: Any) -> dict[str, str]:
    """Return versions of Python, of mgeo's dependencies, and of packages that define `parts`."""
    modules = {cls.__module__ for part in parts for cls in type(part).__mro__}
    owners = _distributions()
    names = {name for module in modules for name in owners.get(module.partition(".")[0], ())}
    if "mgeo.benchmarks.coco" in modules:
        names.add(COCO)
    found = {name: version(name) for name in sorted({*_ALWAYS, *names})}
    return {"python": platform.python_version()} | found | plugin_versions(modules)
