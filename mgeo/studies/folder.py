"""Where finished runs are kept: one file each, named after what determines the run."""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping
from pathlib import Path

from mgeo.studies.dispatch import Key
from mgeo.studies.fingerprint import UncertainError, fingerprint
from mgeo.studies.run import Task

_OLD = re.compile(r"-[0-9a-f]{12,20}-seed\d+\.npz$")  # fingerprints of earlier versions


class NotReusedWarning(RuntimeWarning):
    """Runs are not kept, or not used, because nobody knows for certain what they are runs of."""


def run_files(folder: Path, tasks: Mapping[Key, Task]) -> dict[Key, Path]:
    """The file of each run, without those whose problem or algorithm cannot be identified.

    A file is there whole or not at all, so a comparison can be killed at any time and go on from
    what is there; several may share a folder. Nothing is ever deleted.

    Warns
    -----
    NotReusedWarning
        Once for each problem or algorithm that cannot be identified, and if the folder holds runs
        of a version of mgeo with other fingerprints.
    """
    messages = []
    prints: dict[int, str] = {}
    parts = {id(part): part for task in tasks.values() for part in (task.problem, task.algorithm)}
    for part in parts.values():
        try:
            prints[id(part)] = fingerprint(part)
        except UncertainError as error:
            name = type(part).__name__
            messages.append(
                f"{error}: nobody knows whether a run of {name} is the one asked for, so such runs "
                f"are made, but neither kept nor found again; vouch by an attribute fingerprint of "
                f"{name}, a text that says what it computes"
            )
    found = {}
    for key, task in tasks.items():
        if id(task.problem) in prints and id(task.algorithm) in prints:
            name = type(task.algorithm).__name__
            both = prints[id(task.problem)], prints[id(task.algorithm)]
            run = fingerprint(*both, task.n_eval)
            found[key] = folder / f"{name}-{run}-seed{task.seed}.npz"
    if old := sum(_OLD.search(path.name) is not None for path in folder.glob("*.npz")):
        messages.append(f"{folder} holds runs of an earlier mgeo ({old}): they are not used")
    for message in messages:
        warnings.warn(message, NotReusedWarning, stacklevel=4)  # where `compare` was called
    return found
