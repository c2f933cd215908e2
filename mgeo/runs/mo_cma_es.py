"""MO-CMA-ES, by DEAP's strategy, as a pymoo algorithm."""

from __future__ import annotations

from typing import Any

import numpy as np
from moocore import hv_contributions
from pymoo.core.population import Population

from mgeo._typing import FloatArray
from mgeo.runs.pymoo_algorithms import UnitBox
from mgeo.validation.arguments import validate_integer, validate_number

_PENALTY = 1e-6  # of the squared distance from the box, in its units (Igel, Hansen & Roth 2007)


class MOCMAES(UnitBox):
    """Multiobjective covariance matrix adaptation, mu parents of an offspring each.

    Of Igel, Hansen & Roth (2007), with the step size adaptation of Voss, Hansen & Igel (2010), as
    coded in DEAP, which the extra ``coco`` installs. Survivors are chosen by their contributions
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
    ValueError : if DEAP is not installed, or a parameter is out of range; when it is set up, as of
        `UnitBox`.
    """

    title = "MO-CMA-ES"

    def __init__(self, pop_size: int = 100, sigma: float = 0.05, **options: Any) -> None:
        try:
            import deap.cma  # noqa: F401
        except ImportError as error:
            raise ValueError(
                "MO-CMA-ES needs the extra 'coco': pip install 'mgeo[coco]'"
            ) from error
        super().__init__(**options)
        self.pop_size = validate_integer("pop_size", pop_size, low=4)
        self.sigma = validate_number("sigma", sigma, above=0)

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
