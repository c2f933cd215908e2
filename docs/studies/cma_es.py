"""MO-CMA-ES and COMO-CMA-ES as pymoo algorithms, for the studies that compare with them.

Studies name them ``docs.studies.cma_es:MOCMAES`` and ``docs.studies.cma_es:COMOCMAES`` and are run
in the folder above docs. They need the packages of their authors: pip install deap comocma.
"""

from importlib import import_module

import numpy as np
from moocore import hv_contributions
from pymoo.core.algorithm import Algorithm
from pymoo.core.population import Population

PENALTY = 1e-6  # of the squared distance from the box, in its units (Igel, Hansen & Roth 2007)
TOLERANCE = 1e-6  # of the width of the bounds, where a kernel stops


class UnitBox(Algorithm):
    """Search of bounded real variables that are scaled to the unit cube, without constraints."""

    title: str
    module: str

    def __init__(self, pop_size, sigma, **options):
        super().__init__(**options)
        self.pop_size = pop_size
        self.sigma = sigma

    def _setup(self, problem, **options):
        try:
            import_module(self.module)
        except ImportError as error:
            raise ValueError(f"{self.title} needs its package: pip install deap comocma") from error
        if problem.has_constraints() or problem.xl is None or problem.n_obj != 2:
            raise ValueError(
                f"{self.title}: expected a problem of two objectives with bounds and without "
                "constraints"
            )

    def scale(self, unit):
        """Return the candidates at (n, n_var) points of the cube; clip points outside."""
        xl, xu = self.problem.xl, self.problem.xu
        inside = np.clip(np.asarray(unit, dtype=float), 0.0, 1.0)
        return Population.new(X=np.clip(xl + (xu - xl) * inside, xl, xu))

    def draw(self, n):
        """Return (n, n_var) uniform points of the cube from the algorithm's generator."""
        return self.random_state.random((n, self.problem.n_var))


class MOCMAES(UnitBox):
    """Multiobjective covariance matrix adaptation, one offspring for each of mu parents.

    Igel, Hansen & Roth (2007) with the step size adaptation of Voss, Hansen & Igel (2010), as coded
    in DEAP. Survivors are chosen by their contributions to the hypervolume. Points outside the
    bounds are evaluated at the nearest point inside, with a penalty. The first population is
    uniform in the box.

    Parameters
    ----------
    pop_size : number of parents, and of offspring.
    sigma : initial step size, as a fraction of the width of the bounds. The authors' 0.6 does not
        decrease in time where optima fill only a part of the box.
    """

    title, module = "MO-CMA-ES", "deap.cma"

    def __init__(self, pop_size=100, sigma=0.05, **options):
        super().__init__(pop_size, sigma, **options)

    def _initialize_infill(self):
        self._offspring = list(map(Point, self.draw(self.pop_size)))
        return self.scale(self._offspring)

    def _initialize_advance(self, infills=None, **options):
        from deap.cma import StrategyMultiObjective

        self._assign_fitness(infills)
        self._strategy = StrategyMultiObjective(
            self._offspring, self.sigma, mu=self.pop_size, lambda_=self.pop_size,
            indicator=least_contributor,
        )  # fmt: skip

    def _infill(self):
        strategy, self._offspring = self._strategy, []
        # as DEAP's generate(), with numbers of this algorithm's own generator
        normal = self.random_state.standard_normal((self.pop_size, self.problem.n_var))
        for i, parent in enumerate(strategy.parents):
            parent._ps = "p", i
            step = strategy.sigmas[i] * strategy.A[i] @ normal[i]
            self._offspring.append(Point(np.array(parent) + step))
            self._offspring[-1]._ps = "o", i
        return self.scale(self._offspring)

    def _advance(self, infills=None, **options):
        self._assign_fitness(infills)
        self._strategy.update(self._offspring)
        self.pop = Population.create(*(point.individual for point in self._strategy.parents))

    def _assign_fitness(self, infills):
        points = np.array(self._offspring)
        outside = np.square(points - np.clip(points, 0.0, 1.0)).sum(axis=1)
        F = infills.get("F") + PENALTY * outside[:, None]
        for point, f, individual in zip(self._offspring, F, infills, strict=True):
            point.individual, point.fitness = individual, minimized(f)
        self.pop = infills


class Point(list):
    """An individual of DEAP: a list with a fitness."""


def minimized(f):
    """Return DEAP's fitness of objectives that are minimized."""
    from deap.base import Fitness

    kind = type("Minimized", (Fitness,), {"weights": (-1.0,) * len(f)})
    return kind(f.tolist())


def least_contributor(front, ref):
    """Return the index that DEAP's own indicator returns, which is slower."""
    F = -np.array([point.fitness.wvalues for point in front])
    return int(np.argmin(hv_contributions(F, ref=ref)))


class COMOCMAES(UnitBox):
    """One CMA-ES for each point of the front, by uncrowded hypervolume improvement.

    Touré, Hansen, Auger & Brockhoff (2019), as coded in their ``comocma``. A step evaluates the
    mean that changed last, and a sample of one kernel, drawn at random. The archive of ``comocma``,
    which takes no part in the search, is off: it takes gigabytes in long runs.

    The authors leave three choices to the user. Here kernels begin at uniform points of the box;
    the reference point is the worst value of each objective at these points; and a kernel that
    stops is joined by a new one from another uniform point.

    Parameters
    ----------
    pop_size : number of kernels at the beginning.
    sigma : initial step size, as a fraction of the width of the bounds.
    """

    title, module = "COMO-CMA-ES", "comocma"

    def __init__(self, pop_size=10, sigma=0.2, **options):
        super().__init__(pop_size, sigma, **options)

    def _initialize_infill(self):
        from comocma import Sofomore

        options = {
            "archive": False,
            "restart": lambda _: self._kernels(1),
            "update_order": lambda _: self.random_state.random(),
            "verb_log": 0,  # into files
        }
        self._search = Sofomore(self._kernels(self.pop_size), None, options)
        self._means = {}
        return self._infill()

    def _initialize_advance(self, infills=None, **options):
        self._search.reference_point = infills[: self.pop_size].get("F").max(axis=0).tolist()
        self._advance(infills, **options)

    def _infill(self):
        self._asked = list(self._search._told_indices)  # kernels whose means come first
        self._points = self._search.ask()
        return self.scale(self._points)

    def _advance(self, infills=None, **options):
        self._search.tell(self._points, infills.get("F").tolist())
        self._means |= dict(zip(self._asked, infills, strict=False))
        self.pop = Population.merge(Population.create(*self._means.values()), infills)

    def _kernels(self, n):
        from comocma import get_cmas

        options = {
            "bounds": [0.0, 1.0],
            "randn": lambda *shape: self.random_state.standard_normal(shape),
            "seed": np.nan,  # any number would seed NumPy's global generator
            "tolx": TOLERANCE,
            "verbose": -9,
            "verb_log": 0,
        }
        return get_cmas(self.draw(n).tolist(), self.sigma, options)
