"""MO-CMA-ES and COMO-CMA-ES as pymoo algorithms, for the studies of this folder.

Studies name them as ``cma_es:MOCMAES`` and ``cma_es:COMOCMAES`` and are run from this folder. They
need two packages that nothing else needs: ``pip install deap comocma``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from moocore import hv_contributions
from numpy.typing import ArrayLike, NDArray
from pymoo.core.algorithm import Algorithm
from pymoo.core.individual import Individual
from pymoo.core.population import Population

FloatArray = NDArray[np.float64]


class UnitBox(Algorithm):
    """An algorithm of real variables that are scaled to their bounds, without constraints.

    Raises
    ------
    ValueError : when it is set up, if the problem has constraints, or no bounds.
    """

    title: str

    def _setup(self, problem: Any, **options: Any) -> None:
        if problem.has_constraints():
            raise ValueError(f"{self.title} does not treat constraints, which this problem has")
        if problem.xl is None or problem.xu is None:
            raise ValueError(f"{self.title} needs bounds, to scale variables to")

    def scaled(self, unit: ArrayLike) -> Population:
        """Candidates at (n, n_var) points of the cube; those outside at the nearest inside."""
        xl = np.asarray(self.problem.xl, dtype=float)
        xu = np.asarray(self.problem.xu, dtype=float)
        inside = np.clip(np.asarray(unit, dtype=float), 0.0, 1.0)
        return Population.new(X=np.clip(xl + (xu - xl) * inside, xl, xu))

    def drawn(self, n: int) -> FloatArray:
        """(n, n_var) uniform points of the cube, by the algorithm's own generator."""
        points: FloatArray = self.random_state.random((n, self.problem.n_var))
        return points


_PENALTY = 1e-6  # of the squared distance from the box, in its units (Igel, Hansen & Roth 2007)


class MOCMAES(UnitBox):
    """Multiobjective covariance matrix adaptation, mu parents of an offspring each.

    Of Igel, Hansen & Roth (2007), with the step size adaptation of Voss, Hansen & Igel (2010), as
    coded in DEAP. Survivors are chosen by their contributions
    to the hypervolume. Variables are scaled to their bounds; what lies outside is evaluated at
    the nearest point inside, with a penalty. The first population is uniform in the box. Every
    parent adapts its own covariance, which takes generations: small populations suit it.

    Parameters
    ----------
    pop_size : number of parents, and of offspring.
    sigma : initial step size, as a fraction of the width of the bounds; the authors have 0.6,
        from which it does not come down in time where optima fill a part of the box only.
    options : those of every pymoo algorithm.

    Raises
    ------
    ValueError : when it is set up, for one objective, constraints, or no bounds.
    """

    title = "MO-CMA-ES"

    def __init__(self, pop_size: int = 100, sigma: float = 0.05, **options: Any) -> None:
        super().__init__(**options)
        self.pop_size, self.sigma = pop_size, sigma

    def _setup(self, problem: Any, **options: Any) -> None:
        super()._setup(problem, **options)
        if problem.n_obj < 2:
            raise ValueError("MO-CMA-ES: 1 objective, expected 2 or more")

    def _initialize_infill(self) -> Population:
        self._offspring = list(map(Point, self.drawn(self.pop_size)))
        return self.scaled(self._offspring)

    def _initialize_advance(self, infills: Any = None, **options: Any) -> None:
        from deap.cma import StrategyMultiObjective

        self._told(infills)
        self._strategy = StrategyMultiObjective(
            self._offspring, self.sigma, mu=self.pop_size, lambda_=self.pop_size,
            indicator=least_contributor,
        )  # fmt: skip

    def _infill(self) -> Population:
        strategy, self._offspring = self._strategy, []
        # as its generate(), with numbers of this algorithm's own generator
        normal = self.random_state.standard_normal((self.pop_size, self.problem.n_var))
        for i, parent in enumerate(strategy.parents):
            parent._ps = "p", i
            step = strategy.sigmas[i] * strategy.A[i] @ normal[i]
            self._offspring.append(Point(np.array(parent) + step))
            self._offspring[-1]._ps = "o", i
        return self.scaled(self._offspring)

    def _advance(self, infills: Any = None, **options: Any) -> None:
        self._told(infills)
        self._strategy.update(self._offspring)
        self.pop = Population.create(*(point.individual for point in self._strategy.parents))

    def _told(self, infills: Any) -> None:
        points = np.array(self._offspring)
        outside = np.square(points - np.clip(points, 0.0, 1.0)).sum(axis=1)
        F = infills.get("F") + _PENALTY * outside[:, None]
        for point, f, individual in zip(self._offspring, F, infills, strict=True):
            point.individual, point.fitness = individual, fitness_of(f)
        self.pop = infills


class Point(list[float]):
    """What DEAP takes for an individual: a list with a fitness, and a mark of its parent."""

    fitness: Any
    individual: Any
    _ps: tuple[str, int]


def fitness_of(f: FloatArray) -> Any:
    from deap.base import Fitness

    kind = type("Minimized", (Fitness,), {"weights": (-1.0,) * len(f)})
    return kind(f.tolist())


def least_contributor(front: list[Point], ref: FloatArray) -> int:
    """As DEAP's own, which computes a hypervolume for each point."""
    F = -np.array([point.fitness.wvalues for point in front])
    return int(np.argmin(hv_contributions(F, ref=ref)))


_TOLERANCE = 1e-6  # of the bounds' width, where a kernel stops; theirs is 1e-4 of variables near 1


class COMOCMAES(UnitBox):
    """A CMA-ES for each point of the front, by uncrowded hypervolume improvement.

    Of Touré, Hansen, Auger & Brockhoff (2019), for two objectives, as coded in their ``comocma``.
    A step evaluates the mean that was last changed, and a sample of one kernel, drawn at random.
    Variables are scaled to their bounds, which CMA-ES itself keeps. The archive of ``comocma``,
    which takes no part in the search, is off: in long runs it takes gigabytes.

    What the authors leave to the user: kernels begin at uniform points of the box; the reference
    point is the worst value of each objective at these; and a kernel that stops is joined by a new
    one from another such point.

    Parameters
    ----------
    pop_size : number of kernels at the beginning.
    sigma : initial step size, as a fraction of the width of the bounds.
    options : those of every pymoo algorithm.

    Raises
    ------
    ValueError : when it is set up, unless the problem has two objectives, two variables or more,
        bounds, and no constraints.
    """

    title = "COMO-CMA-ES"

    def __init__(self, pop_size: int = 10, sigma: float = 0.2, **options: Any) -> None:
        super().__init__(**options)
        self.pop_size, self.sigma = pop_size, sigma

    def _setup(self, problem: Any, **options: Any) -> None:
        super()._setup(problem, **options)
        if problem.n_obj != 2:
            raise ValueError(f"COMO-CMA-ES: {problem.n_obj} objective(s), expected 2")
        if problem.n_var < 2:  # a limit of CMA-ES as coded
            raise ValueError("COMO-CMA-ES: 1 variable, expected 2 or more")

    def _initialize_infill(self) -> Population:
        from comocma import Sofomore

        options = {
            "archive": False,
            "restart": lambda _: self._kernels(1),
            "update_order": lambda _: self.random_state.random(),
            "verb_log": 0,  # which would be into files
        }
        self._search = Sofomore(self._kernels(self.pop_size), None, options)
        self._means: dict[int, Individual] = {}
        return self._infill()

    def _initialize_advance(self, infills: Any = None, **options: Any) -> None:
        self._search.reference_point = infills[: self.pop_size].get("F").max(axis=0).tolist()
        self._advance(infills, **options)

    def _infill(self) -> Population:
        self._asked = list(self._search._told_indices)  # kernels whose means come first
        self._points = self._search.ask()
        return self.scaled(self._points)

    def _advance(self, infills: Any = None, **options: Any) -> None:
        self._search.tell(self._points, infills.get("F").tolist())
        self._means |= dict(zip(self._asked, infills, strict=False))
        self.pop = Population.merge(Population.create(*self._means.values()), infills)

    def _kernels(self, n: int) -> list[Any]:
        from comocma import get_cmas

        options = {
            "bounds": [0.0, 1.0],
            "randn": lambda *shape: self.random_state.standard_normal(shape),
            "seed": np.nan,  # it would be that of NumPy's global generator
            "tolx": _TOLERANCE,
            "verbose": -9,
            "verb_log": 0,
        }
        kernels: list[Any] = get_cmas(self.drawn(n).tolist(), self.sigma, options)
        return kernels
