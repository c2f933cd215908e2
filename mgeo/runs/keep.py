"""What a run keeps in its folder while it is under way, so that it survives anything."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pymoo.core.algorithm import LoopwiseAlgorithm
from pymoo.core.callback import CallbackCollection

from mgeo.algorithms.base import ExtremalOptimization
from mgeo.persistence import record_file
from mgeo.persistence.checkpoint import Checkpoint
from mgeo.persistence.recorder import Recorder

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm

    from mgeo.runs.recipe import Recipe
    from mgeo.runs.solve import State

CHECKPOINT_FILE, RECORD_FOLDER = "run.checkpoint", "evaluations"

#: Files in which a problem's own tools prove a solution of the front, see `mgeo.report`.
VERIFICATION_FILES = "verification*.json"


class Keeper:
    """Keeps one run: checkpoints, for algorithms that have them, and every evaluation if asked.

    Parameters
    ----------
    folder
        The run's.
    recipe
        Goes into each checkpoint, so that this file alone is enough to go on.
    algorithm
        The one to be run, of which copies may be kept as well.
    record
        Whether to record every evaluation (see `mgeo.Recorder`).
    every_seconds
        Time between two checkpoints.

    Raises
    ------
    ValueError
        If the evaluations of this algorithm cannot be recorded.
    """

    def __init__(
        self,
        folder: Path,
        recipe: Recipe,
        algorithm: Algorithm,
        *,
        record: bool = False,
        every_seconds: float = 5.0,
    ) -> None:
        if record and isinstance(algorithm, LoopwiseAlgorithm):
            raise ValueError(
                f"evaluations of {recipe.algorithm!r} cannot be recorded: expected an algorithm "
                "that hands its candidates over a generation at a time"
            )
        self.folder = folder
        self.record = record
        self._recipe = recipe
        self._every_seconds = every_seconds
        self._checkpoint: Checkpoint | None = None
        self._recorder: Recorder | None = None
        self._algorithm = algorithm
        self._began = False  # here, and not in a run before that is resumed

    @property
    def path(self) -> Path:
        """The checkpoint."""
        return self.folder / CHECKPOINT_FILE

    @property
    def can_go_on(self) -> bool:
        """Whether there is a checkpoint, and evaluations that would be lost without it."""
        return self._checkpoint is not None and bool(self._checkpoint.generation) and self._made > 0

    @property
    def _made(self) -> int:
        """Evaluations that did not fail."""
        evaluator = self._algorithm.evaluator
        made: int = evaluator.n_eval - getattr(evaluator, "n_failed", 0)
        return made

    @property
    def error(self) -> OSError | None:
        """Why the latest checkpoint could not be written, None if it was."""
        return None if self._checkpoint is None else self._checkpoint.error

    def begin(self, algorithm: Algorithm, state: State) -> None:
        """Take charge of a run that is set up or resumed; what another one kept here goes."""
        self._algorithm = algorithm
        begins = self._began = (algorithm.n_iter or 1) == 1
        if begins:
            for file in self.folder.glob(VERIFICATION_FILES):
                file.unlink(missing_ok=True)
        kept: list[Any] = []
        if self.record:
            self._recorder = Recorder(self.folder / RECORD_FOLDER, overwrite=begins)
            kept.append(self._recorder)
        elif begins:
            record_file.remove(self.folder / RECORD_FOLDER)
        if isinstance(algorithm, ExtremalOptimization):

            def notes() -> Mapping[str, Any]:
                recipe = self._recipe.to_dict()
                return {"recipe": recipe, "record": self.record, **state.notes()}

            self._checkpoint = Checkpoint(
                self.path, every_seconds=self._every_seconds, notes=notes, warn=False
            )
            kept.append(self._checkpoint)
            if begins:
                self._checkpoint.write(algorithm)
        elif begins:
            self.path.unlink(missing_ok=True)
        algorithm.callback = CallbackCollection(*kept)

    def end(self, algorithm: Algorithm) -> None:
        """Keep the last generation, after an orderly end."""
        if self._recorder is not None:
            self._recorder.flush()
        if self._checkpoint is not None:
            self._checkpoint.write(algorithm)

    def drop_if_useless(self) -> None:
        """Remove a checkpoint and a record of this run without which nothing is lost.

        A checkpoint from before stays: of a run that could not even be resumed it is all there is.
        """
        if self._began and not self.can_go_on:
            self.path.unlink(missing_ok=True)
        if self._began and self._recorder is not None and not self._made:
            record_file.remove(self.folder / RECORD_FOLDER)
