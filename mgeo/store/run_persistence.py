"""Checkpoints and the record of one run in its folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pymoo.core.algorithm import Algorithm, LoopwiseAlgorithm
from pymoo.core.callback import Callback

from mgeo.algorithms.base import ExtremalOptimization
from mgeo.store.checkpoint import Checkpoint
from mgeo.store.recorder import Recorder
from mgeo.store.run import RunConfiguration
from mgeo.store.run_folder import CHECKPOINT_FILE, RECORD_FOLDER


class RunPersistence:
    """Saves one run while it continues: checkpoints of the MGEO family, and a record if requested.

    Parameters
    ----------
    folder
        Folder of the run.
    configuration
        Written into each checkpoint, so that this file alone is enough to continue.
    algorithm
        The algorithm to be run.
    record
        Whether to record every evaluation (see `mgeo.Recorder`).

    Raises
    ------
    ValueError
        If the evaluations of this algorithm cannot be recorded.
    """

    def __init__(
        self,
        folder: Path,
        configuration: RunConfiguration,
        algorithm: Algorithm,
        *,
        record: bool = False,
    ) -> None:
        if record and isinstance(algorithm, LoopwiseAlgorithm):
            raise ValueError(
                f"evaluations of {configuration.algorithm!r} cannot be recorded: expected an "
                "algorithm that evaluates its candidates a generation at a time"
            )
        self.folder = folder
        self.record = record
        self.recorder: Recorder | None = None
        self._configuration = configuration
        self._checkpoint: Checkpoint | None = None

    def callbacks(
        self, algorithm: Algorithm, notes: Callable[[], Mapping[str, Any]]
    ) -> list[Callback]:
        """Return the callbacks for an algorithm that is set up or resumed.

        Parameters
        ----------
        notes
            Function that returns ``started``, ``wall_time_s`` and ``rough`` of `Notes`.
        """
        callbacks: list[Callback] = []
        if self.record:
            is_new = (algorithm.n_iter or 1) == 1
            self.recorder = Recorder(self.folder / RECORD_FOLDER, overwrite=is_new)
            callbacks.append(self.recorder)
        if isinstance(algorithm, ExtremalOptimization):
            fixed = {"configuration": self._configuration.model_dump(), "record": self.record}
            self._checkpoint = Checkpoint(
                self.folder / CHECKPOINT_FILE, notes=lambda: {**fixed, **notes()}, warn=False
            )
            callbacks.append(self._checkpoint)
        return callbacks

    @property
    def can_resume(self) -> bool:
        """Whether a checkpoint of this run was written."""
        return self._checkpoint is not None and self._checkpoint.generation is not None

    @property
    def error(self) -> OSError | None:
        """The error of the latest attempt to write a checkpoint, None if there was none."""
        return None if self._checkpoint is None else self._checkpoint.error
