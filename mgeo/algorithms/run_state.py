"""State of a run between generations, and the table that pymoo prints during a run."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from pymoo.util.display.column import Column
from pymoo.util.display.output import Output

from mgeo._typing import FloatArray, IntArray
from mgeo.algorithms.archive import ParetoArchive


@dataclass(kw_only=True, eq=False, slots=True)
class RunState:
    """Data of an MGEO run that persist between generations.

    A checkpoint contains every field (see `mgeo.algorithms.state`); other attributes cannot be set.
    An algorithm with additional state declares a subclass, also a dataclass with slots, and creates
    it in `create_state`. Allowed field types are arrays of numbers of constant shape, random
    streams, archives, numbers, strings, and lists or dataclasses of these. Candidates, counters,
    evaluator and the random stream of the algorithm are attributes of pymoo's `Algorithm`.

    Attributes
    ----------
    streams : list of numpy.random.Generator
        Random streams, one per walker.
    front : ParetoArchive
        Archive of nondominated points.
    n_generations : int
        Number of completed generations.
    walkers : array, shape (n_walkers, n_coordinates)
        Current points.
    taus, improvement_chances : array, shape (n_walkers, n_obj)
        For an adaptive tau, its current value and the last chance of improvement.
    current_fitness, incumbent_fitness : array, shape (n_walkers, 1 + n_obj)
        Fitness of the current point and best fitness so far of each walker, see
        `selection.compute_fitness`. Updated only if tau is adaptive or walkers restart.
    n_idle_generations : array of int, shape (n_walkers,)
        Generations since the last progress of each walker. Updated only if walkers restart.
    initial_designs : array, shape (n_walkers, n_var)
        Initial designs that the first generation evaluates. Rows are NaN for walkers that start at
        a random point or at a point that is already evaluated.
    """

    streams: list[np.random.Generator]
    front: ParetoArchive
    n_generations: int
    walkers: FloatArray
    taus: FloatArray
    improvement_chances: FloatArray
    current_fitness: FloatArray
    incumbent_fitness: FloatArray
    n_idle_generations: IntArray
    initial_designs: FloatArray

    @classmethod
    def create(
        cls,
        streams: list[np.random.Generator],
        front: ParetoArchive,
        walkers: FloatArray,
        **extra_fields: Any,
    ) -> Self:
        """Create the initial state of a run.

        Arrays other than `walkers` are not initialized; `ExtremalOptimization.reset_walkers` sets
        them.

        Parameters
        ----------
        streams, front, walkers
            Fields of the state.
        **extra_fields
            Additional fields of a subclass.
        """
        n, n_obj = len(walkers), front.F.shape[1]
        return cls(
            streams=streams,
            front=front,
            n_generations=0,
            walkers=walkers,
            taus=np.empty((n, n_obj)),
            improvement_chances=np.empty((n, n_obj)),
            current_fitness=np.empty((n, 1 + n_obj)),
            incumbent_fitness=np.empty((n, 1 + n_obj)),
            n_idle_generations=np.empty(n, dtype=np.intp),
            initial_designs=np.empty((n, 0)),
            **extra_fields,
        )


class ArchiveOutput(Output):
    """Progress table that pymoo prints during a run, with one row per generation.

    Columns are the generation, evaluations, size of the front, smallest constraint violation ``cv``
    (for constrained problems), smallest value of each objective, and failed evaluations. The
    algorithm must have a `mgeo.ParetoArchive` as its attribute ``front``.
    """

    def __init__(self) -> None:
        super().__init__()
        self.n_failed = Column("failed", width=6)
        self.n_nds = Column("n_nds", width=6)
        self.cv = Column("cv")
        self.minima: list[Column] = []

    def initialize(self, algorithm: Any) -> None:
        problem = algorithm.problem
        self.minima = [Column(f"f{j + 1}_min") for j in range(problem.n_obj)]
        constrained = [self.cv] if problem.has_constraints() else []
        self.columns += [self.n_nds, *constrained, *self.minima, self.n_failed]

    def update(self, algorithm: Any) -> None:
        super().update(algorithm)
        front = algorithm.front
        has_points = len(front) > 0
        # pymoo prints a dash for None.
        self.n_failed.set(getattr(algorithm.evaluator, "n_failed", None))
        self.n_nds.set(len(front))
        self.cv.set(front.violation if has_points else None)
        for j, column in enumerate(self.minima):
            column.set(front.F[:, j].min() if has_points and front.violation == 0 else None)
