"""What a run saves in its folder while it is under way, so that it survives anything."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pymoo.core.algorithm import Algorithm, LoopwiseAlgorithm
from pymoo.core.callback import Callback, CallbackCollection

from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.staged import MGEOStaged
from mgeo.store import record_file
from mgeo.store.atomic import write_file
from mgeo.store.checkpoint import Checkpoint, content
from mgeo.store.recorder import Recorder
from mgeo.store.run import RunConfiguration
from mgeo.store.run_folder import (
    CHECKPOINT_FILE,
    RECORD_FOLDER,
    RUN_FILE,
    remove_results,
    remove_verifications,
)


class RunPersistence(Callback):
    """Saves one run: checkpoints, for algorithms that have them, and every evaluation if asked.

    What another run has left in the folder stays until a candidate of this one has succeeded; of
    one that saves nothing on its way, until it has ended (see `take_over`).

    Parameters
    ----------
    folder
        The run's.
    configuration
        Goes into each checkpoint, so that this file alone is enough to go on.
    algorithm
        The one to be run, or to be copied and run.
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
        super().__init__()
        if record and isinstance(algorithm, LoopwiseAlgorithm):
            raise ValueError(
                f"evaluations of {configuration.algorithm!r} cannot be recorded: expected an "
                "algorithm that hands its candidates over a generation at a time"
            )
        self.folder = folder
        self.path = folder / CHECKPOINT_FILE
        self.record = record
        self.waits = False  # for something to put in the place of what another run has left
        self._configuration = configuration
        self._algorithm = algorithm
        self._checkpoint: Checkpoint | None = None
        self._recorder: Recorder | None = None
        self._first = b""  # checkpoint, from which nothing is made yet
        self._began = False  # here, and not in a run before that is resumed

    @property
    def can_resume(self) -> bool:
        """Whether there is a checkpoint, and evaluations that would be lost without it."""
        return self._checkpoint is not None and bool(self._checkpoint.generation) and self.made > 0

    @property
    def error(self) -> OSError | None:
        """Why the latest checkpoint could not be written, None if it was."""
        return None if self._checkpoint is None else self._checkpoint.error

    @property
    def made(self) -> int:
        """Evaluations that did not fail."""
        evaluator = self._algorithm.evaluator
        made: int = evaluator.n_eval - getattr(evaluator, "n_failed", 0)
        return made

    def begin(self, algorithm: Algorithm, notes: Callable[[], dict[str, Any]]) -> None:
        """Take charge of a run that is set up or resumed.

        Parameters
        ----------
        algorithm
            The one that runs.
        notes
            Gives ``started``, ``wall_time_s``, ``seen`` and ``nearest`` of `Notes` as JSON values.

        Raises
        ------
        OSError
            If not even the first checkpoint can be written.
        """
        self._algorithm = algorithm
        begins = (algorithm.n_iter or 1) == 1
        callbacks: list[Any] = [self]
        if self.record:
            self._recorder = _Recorder(self, overwrite=begins)
            callbacks.insert(0, self._recorder)
        if isinstance(algorithm, ExtremalOptimization):
            own = {"configuration": self._configuration.model_dump(), "record": self.record}
            self._checkpoint = Checkpoint(self.path, notes=lambda: own | notes(), warn=False)
            self._first = content(algorithm, own | notes())
        algorithm.callback = CallbackCollection(*callbacks)
        self.waits = begins
        left = (RUN_FILE, CHECKPOINT_FILE, RECORD_FOLDER)
        if not any((self.folder / name).exists() for name in left):
            self.take_over()

    def take_over(self) -> None:
        """Remove what another run has left in the folder, unless that is done.

        If this one was killed, its record and its checkpoint would be taken for those of the other.

        Raises
        ------
        OSError
            If not even the first checkpoint can be written; what was there is unchanged then.
        """
        if not self.waits:
            return
        if self._first:
            write_file(self.path, self._first)
        else:
            self.path.unlink(missing_ok=True)
        self.waits, self._began = False, True
        if not self.record:
            record_file.remove(self.folder / RECORD_FOLDER)
        if self._first or self.record:  # else the results of this one take their place
            remove_results(self.folder)
        remove_verifications(self.folder)

    def _update(self, algorithm: Any) -> None:
        if self._checkpoint is not None and self.made:
            self.take_over()
            self._checkpoint.update(algorithm)

    def end(self) -> None:
        """Save the last generation, after an orderly end."""
        if self._recorder is not None:
            self._recorder.flush()
        if self._checkpoint is not None and self.made:
            self._checkpoint.write(self._algorithm)

    def conclude(self) -> None:
        """Record what a staged run evaluated once more at its end, after its last generation."""
        concluded = isinstance(self._algorithm, MGEOStaged) and self._algorithm.concluded
        if self._recorder is not None and concluded:
            self._recorder.take(self._algorithm)
            self._recorder.flush()

    def drop_if_useless(self) -> None:
        """Remove a checkpoint of this run without which nothing is lost.

        One from before stays: of a run that could not even be resumed it is all there is.
        """
        if self._began and not self.can_resume:
            self.path.unlink(missing_ok=True)


class _Recorder(Recorder):
    """Keeps to itself what is no reason yet to take over."""

    def __init__(self, run: RunPersistence, *, overwrite: bool) -> None:
        super().__init__(run.folder / RECORD_FOLDER, overwrite=overwrite)
        self._run = run

    def flush(self) -> None:
        if self._run.made:
            self._run.take_over()
            super().flush()
