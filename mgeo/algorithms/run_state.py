"""What a run carries from one generation to the next, and what of it is printed."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from pymoo.util.display.column import Column
from pymoo.util.display.output import Output

from mgeo._typing import FloatArray, IntArray
from mgeo.algorithms.archive import ParetoArchive


@dataclass(kw_only=True, eq=False, slots=True)
class RunState:
    """All that a run of the family carries from one generation to the next.

    A checkpoint contains every field (`mgeo.algorithms.state`), and attributes that are not fields
    cannot be set. A variant that carries more declares the fields in a subclass that is a dataclass
    with slots, too, and creates its state in `new_state`. Fields are arrays of numbers of constant
    shape, random streams, archives, numbers, text, or lists or dataclasses of these. Candidates,
    counters, the evaluator and the random stream of the algorithm belong to pymoo's `Algorithm`.

    Attributes
    ----------
    streams : one `numpy.random.Generator` per walker.
    front : the archive.
    n_generations : how many generations are complete.
    walkers : (n_walkers, n_coordinates) the current points.
    taus, chances : (n_walkers, n_obj) of an adaptive tau: its value and last chance of improvement.
    current_fitness, incumbent_fitness : (n_walkers, 1 + n_obj) `selection.fitness` of the walkers'
        current points, and the best they have seen; kept if tau is adaptive or walkers restart.
    idle : (n_walkers,) generations since a walker's last progress; kept if walkers restart.
    starts : (n_walkers, n_var) starting points that the first generation evaluates; NaN in the rows
        of walkers that start at random, or at a point that was evaluated before the run.
    """

    streams: list[np.random.Generator]
    front: ParetoArchive
    n_generations: int
    walkers: FloatArray
    taus: FloatArray
    chances: FloatArray
    current_fitness: FloatArray
    incumbent_fitness: FloatArray
    idle: IntArray
    starts: FloatArray

    @classmethod
    def begin(
        cls,
        streams: list[np.random.Generator],
        front: ParetoArchive,
        walkers: FloatArray,
        **more: Any,
    ) -> Self:
        """A state before the first generation; `more` are fields of a subclass.

        What is known of walkers is not filled in yet.
        """
        n, n_obj = len(walkers), front.F.shape[1]
        return cls(
            streams=streams,
            front=front,
            n_generations=0,
            walkers=walkers,
            taus=np.empty((n, n_obj)),
            chances=np.empty((n, n_obj)),
            current_fitness=np.empty((n, 1 + n_obj)),
            incumbent_fitness=np.empty((n, 1 + n_obj)),
            idle=np.empty(n, dtype=np.intp),
            starts=np.empty((n, 0)),
            **more,
        )


class ArchiveOutput(Output):
    """Generation, evaluations, points on the front, violation, best objectives, failures.

    It reads `algorithm.front`, a `mgeo.ParetoArchive`. `cv`, the least constraint violation,
    appears with constrained problems; `failed` shows a dash under an evaluator that does not
    count failures.
    """

    def __init__(self) -> None:
        super().__init__()
        self.failed = Column("failed", width=6)
        self.n_nds = Column("n_nds", width=6)
        self.cv = Column("cv")
        self.best: list[Column] = []

    def initialize(self, algorithm: Any) -> None:
        """Add the columns that depend on the problem."""
        problem = algorithm.problem
        self.best = [Column(f"f{j + 1}_min") for j in range(problem.n_obj)]
        constrained = [self.cv] if problem.has_constraints() else []
        self.columns += [self.n_nds, *constrained, *self.best, self.failed]

    def update(self, algorithm: Any) -> None:
        """Read the archive; a column without a value shows a dash."""
        super().update(algorithm)
        front = algorithm.front
        found = len(front) > 0
        self.failed.set(getattr(algorithm.evaluator, "n_failed", None))
        self.n_nds.set(len(front))
        self.cv.set(front.violation if found else None)
        for j, column in enumerate(self.best):
            column.set(front.F[:, j].min() if found and front.violation == 0 else None)
