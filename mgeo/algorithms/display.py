"""What is printed while an algorithm with a `ParetoArchive` runs: no cost beyond reading it."""

from typing import Any

from pymoo.util.display.column import Column
from pymoo.util.display.output import Output


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
