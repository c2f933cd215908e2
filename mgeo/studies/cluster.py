"""Whether the workers of a Dask cluster can load what they are to run.

joblib would wait for ever for a worker that cannot: so each is asked before the runs.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mgeo.studies.fingerprint.modules import source_file


class WorkerError(ValueError):
    """A worker that cannot load a problem or an algorithm."""


def prepare_workers(client: Any, parts: Iterable[Any]) -> None:
    """Have every worker of a `distributed.Client` load problems and algorithms.

    A module that one lacks is sent to all, and to those that come later, if it is no installed
    distribution's: a file beside the study, or a package under development, as a zip file.

    Raises
    ------
    WorkerError
        If one still cannot; the message names the worker and the module.
    """
    from distributed.diagnostics.plugin import UploadFile
    from distributed.protocol.pickle import dumps

    content = dumps(list(parts))
    sent: set[str] = set()
    while lacking := _lacking(client, content):
        worker, module, error = lacking
        top = module.partition(".")[0]
        place = source_file(top) if top and top not in sent else None
        if place is None:
            raise WorkerError(
                f"worker {worker} cannot load {module or 'what it is to run'}: {error}; expected "
                "the same distributions on every worker as here"
            )
        sent.add(top)
        with TemporaryDirectory() as folder:
            try:
                client.register_plugin(
                    UploadFile(_whole(place, folder), load=place.stem == "__init__")
                )
            except Exception as failed:  # what importing it there raises
                raise WorkerError(f"worker {worker} cannot load {module}: {failed}") from failed


def _whole(place: Path, folder: str) -> str:
    """The file to send for a module: its own, or of a package a zip of its folder."""
    if place.stem != "__init__":
        return str(place)
    package = place.parent
    target = str(Path(folder, package.name))
    return shutil.make_archive(target, "zip", root_dir=package.parent, base_dir=package.name)


def _lacking(client: Any, content: bytes) -> tuple[str, str, str] | None:
    """The first worker that cannot load this, the module that it lacks, if any, and its error."""
    told = client.run(_loaded, content)
    return next(((worker, *found) for worker, found in told.items() if found), None)


def _loaded(content: bytes) -> tuple[str, str] | None:
    """On a worker: why this cannot be loaded."""
    from distributed.protocol.pickle import loads

    try:
        loads(content)
    except Exception as error:  # whatever foreign code raises while it is imported
        return getattr(error, "name", None) or "", f"{type(error).__name__}: {error}"
    return None
