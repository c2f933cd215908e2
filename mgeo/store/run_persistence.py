"""What a run saves in its folder while it is under way, so that it survives anything."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pymoo.core.algorithm import Algorithm, LoopwiseAlgorithm
from pymoo.core.callback import CallbackCollection

from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.staged import MGEOStaged
from mgeo.store import record_file
from mgeo.store.checkpoint import Checkpoint
from mgeo.store.recorder import Recorder
from mgeo.store.run import RunConfiguration
from mgeo.store.run_folder import CHECKPOINT_FILE, RECORD_FOLDER, remove_results


class RunPersistence:
    """Saves one run: checkpoints, for algorithms that have them, and every evaluation if asked.

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
        if record and isinstance(algorithm, LoopwiseAlgorithm):
            raise ValueError(
                f"evaluations of {configuration.algorithm!r} cannot be recorded: expected an "
                "algorithm that hands its candidates over a generation at a time"
            )
        self.folder = folder
        self.path = folder / CHECKPOINT_FILE
        self.record = record
        self._configuration = configuration
        self._algorithm = algorithm
        self._checkpoint: Checkpoint | None = None
        self._recorder: Recorder | None = None
        self._began = False  # here, and not in a run before that is resumed

    @property
    def can_resume(self) -> bool:
        """Whether there is a checkpoint, and evaluations that would be lost without it."""
        return self._checkpoint is not None and bool(self._checkpoint.generation) and self._made > 0

    @property
    def error(self) -> OSError | None:
        """Why the latest checkpoint could not be written, None if it was."""
        return None if self._checkpoint is None else self._checkpoint.error

    @property
    def _made(self) -> int:
        """Evaluations that did not fail."""
        evaluator = self._algorithm.evaluator
        made: int = evaluator.n_eval - getattr(evaluator, "n_failed", 0)
        return made

    def begin(self, algorithm: Algorithm, notes: Callable[[], dict[str, Any]]) -> None:
        """Take charge of a run that is set up or resumed; what another one saved here goes.

        Parameters
        ----------
        algorithm
            The one that runs.
        notes
            Gives ``started``, ``wall_time_s``, ``seen`` and ``nearest`` of `Notes` as JSON values.

        Raises
        ------
        OSError
            If not even the first checkpoint can be written; what was there is unchanged then.
        """
        self._algorithm = algorithm
        begins = (algorithm.n_iter or 1) == 1
        callbacks: list[Any] = []
        if isinstance(algorithm, ExtremalOptimization):
            own = {"configuration": self._configuration.model_dump(), "record": self.record}
            self._checkpoint = Checkpoint(self.path, notes=lambda: own | notes(), warn=False)
            callbacks.append(self._checkpoint)
            if begins:
                self._checkpoint.write(algorithm)
                if self._checkpoint.error is not None:  # nor would it be better at the end
                    raise self._checkpoint.error
        elif begins:
            self.path.unlink(missing_ok=True)
        self._began = begins
        if begins:
            remove_results(self.folder)
        if self.record:
            self._recorder = Recorder(self.folder / RECORD_FOLDER, overwrite=begins)
            callbacks.insert(0, self._recorder)
        elif begins:
            record_file.remove(self.folder / RECORD_FOLDER)
        algorithm.callback = CallbackCollection(*callbacks)

    def end(self) -> None:
        """Save the last generation, after an orderly end."""
        if self._recorder is not None:
            self._recorder.flush()
        if self._checkpoint is not None:
            self._checkpoint.write(self._algorithm)

    def conclude(self) -> None:
        """Record what a staged run evaluated once more at its end, after its last generation."""
        concluded = isinstance(self._algorithm, MGEOStaged) and self._algorithm.concluded
        if self._recorder is not None and concluded:
            self._recorder.take(self._algorithm)
            self._recorder.flush()

    def drop_if_useless(self) -> None:
        """Remove a checkpoint and a record of this run without which nothing is lost.

        A checkpoint from before stays: of a run that could not even be resumed it is all there is.
        """
        if self._began and not self.can_resume:
            self.path.unlink(missing_ok=True)
        if self._began and self._recorder is not None and not self._made:
            record_file.remove(self.folder / RECORD_FOLDER)
