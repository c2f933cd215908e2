"""Published results of single-objective variants, and the test functions of the publications.

The source is leobeckerdaluz/GEO_OptimizationAlgorithms (MIT; a master's thesis at INPE). The
numbers are mean and median of the best value of 50 runs of 100,000 evaluations each, with one
walker per run.

- real, real2: src/real1real2.txt of August 2022, parameters from ObjectiveFunctions_parameters.cs.
  The source penalizes values out of bounds (2 (x - bound)^2 is added), and mgeo clips them.
- canonical, var and their A-GEO1: novo__exec_GEOAGEO.txt of February 2022. At that time, the source
  decoded b bits as xl + (xu - xl) m / 2^b; the divisor of mgeo is 2^b - 1.
- A-GEO2 of canonical and var: src/BINARIOS_ALL.txt of August 2022, in which the chance of
  improvement of A-GEO1 is always zero (see `mgeo.algorithms.selection`).
- A-GEO2 of real and real2: "AGEOreal1_P" and "AGEOreal2_P_DS" of DEPRECATED_xlsx/
  novo__AGEO2_GEOreal1P_AGEO2real1P_vs_AGEO2real1PAA.xlsx and novo_final_GEOreal2PDS_vs_
  AGEOreal2PDS.xlsx, February 2022.
"""

from dataclasses import dataclass

import numpy as np
from pymoo.core.problem import Problem

from mgeo import MGEOCanonical, MGEOReal, MGEOReal2, MGEOVar
from mgeo.algorithms import BitStrings

EVALUATIONS = 100_000


def griewank(X):
    i = np.arange(1, X.shape[1] + 1)
    return 1 + (X**2).sum(axis=1) / 4000 - np.cos(X / np.sqrt(i)).prod(axis=1)


def rastrigin(X):
    """Return Rastrigin's function with the amplitude 3 instead of the usual 10."""
    return 3.0 * X.shape[1] + (X**2 - 3.0 * np.cos(2 * np.pi * X)).sum(axis=1)


def rosenbrock(X):
    a, b = X[:, :-1], X[:, 1:]
    return (100.0 * (a**2 - b) ** 2 + (1.0 - a) ** 2).sum(axis=1)


def schwefel(X):
    """Return Schwefel's function, whose minimum is 1.3e-4 for 10 variables."""
    return 418.9829 * X.shape[1] - (X * np.sin(np.sqrt(np.abs(X)))).sum(axis=1)


def ackley(X):
    square, cosine = (X**2).mean(axis=1), np.cos(2 * np.pi * X).mean(axis=1)
    return -20.0 * np.exp(-0.2 * np.sqrt(square)) - np.exp(cosine) + np.e + 20.0


#: Function, number of variables, half the width of the bounds, and bits per variable.
FUNCTIONS = {
    "Griewank": (griewank, 10, 600.0, 14),
    "Rastrigin": (rastrigin, 20, 5.12, 16),
    "Rosenbrock": (rosenbrock, 2, 2.048, 13),
    "Schwefel": (schwefel, 10, 500.0, 16),
    "Ackley": (ackley, 30, 30.0, 16),
}


class Function(Problem):
    """Pymoo problem of one of the `FUNCTIONS`.

    With `penalized`, the bounds are far away, and 2 (x - bound)^2 is added outside the original
    bounds. This suits steps relative to the value, which often leave the bounds. The initial points
    must then be given.
    """

    def __init__(self, name, penalized=False):
        self.plain, n_var, self.half, self.n_bits = FUNCTIONS[name]
        self.penalized = penalized
        bound = 1e9 if penalized else self.half
        super().__init__(n_var=n_var, n_obj=1, xl=-bound, xu=bound)

    def function(self, X):
        if not self.penalized:
            return self.plain(X)
        return self.plain(X) + 2.0 * (np.maximum(np.abs(X) - self.half, 0.0) ** 2).sum(axis=1)


@dataclass(frozen=True)
class Oracle:
    """Published mean and median of the best values of a variant on a test function."""

    function: str
    variant: type
    parameters: dict
    mean: float
    median: float

    @property
    def label(self):
        given = ", ".join(f"{key}={value!r}" for key, value in self.parameters.items())
        return f"{self.variant.__name__}({given})"

    def bests(self, n_walkers, seed=1, evaluations=EVALUATIONS):
        """Return the best value of each walker after a number of evaluations per walker.

        The walkers are independent, so that each walker is a separate run. The loop avoids pymoo's
        populations, which would take most of the time.
        """
        parameters, problem = dict(self.parameters), Function(self.function)
        if issubclass(self.variant, BitStrings):
            parameters["bits"] = problem.n_bits
        elif parameters["perturbation"] == "relative":
            starts = np.random.default_rng(seed).uniform(-1, 1, (n_walkers, problem.n_var))
            parameters["sampling"] = problem.half * starts
            problem = Function(self.function, penalized=True)
        algorithm = self.variant(n_walkers=n_walkers, **parameters).setup(problem, seed=seed)
        best, done = np.full(n_walkers, np.inf), 0
        while done < evaluations:
            f = problem.function(algorithm.generate_candidates())
            algorithm.accept(f[:, None], np.zeros(len(f)))
            by_walker = f.reshape(n_walkers, -1)
            best = np.minimum(best, by_walker.min(axis=1))
            done += by_walker.shape[1]
        return best


def _real(function, perturbation, sigma, tau, mean, median):
    parameters = {"sigma": sigma, "tau": tau, "perturbation": perturbation}
    return Oracle(function, MGEOReal, parameters, mean, median)


def _real2(function, perturbation, sigma, tau, n_steps, divisor, schedule, mean, median):
    parameters = {
        "sigma": sigma, "tau": tau, "perturbation": perturbation,
        "n_steps": n_steps, "divisor": divisor, "schedule": schedule,
    }  # fmt: skip
    return Oracle(function, MGEOReal2, parameters, mean, median)


def _bits(variant, tau, *rows):
    taus = tau if isinstance(tau, list) else [tau] * len(rows)
    return [
        Oracle(function, variant, {"tau": tau}, mean, median)
        for tau, (function, mean, median) in zip(taus, rows, strict=True)
    ]


ORACLES = (
    _real("Griewank", "relative", 1.2, 1.5, 0.0, 0.0),
    _real("Rastrigin", "relative", 1.0, 1.5, 0.0, 0.0),
    _real("Rosenbrock", "relative", 2.4, 5.5, 5.60e-3, 3.56e-3),
    _real("Schwefel", "relative", 1.8, 5.5, 109.7, 104.6),
    _real("Ackley", "relative", 0.8, 1.0, 2.8e-16, 0.0),
    _real("Griewank", "range", 0.005, 5.5, 0.1429, 0.1499),
    _real("Rastrigin", "range", 0.03, 5.5, 0.0914, 0.0894),
    _real("Rosenbrock", "range", 0.005, 6.0, 1.058e-6, 7.91e-7),
    _real("Schwefel", "range", 0.09, 3.5, 83.04, 31.75),
    _real("Ackley", "range", 0.01, 6.0, 0.0695, 0.0700),
    _real("Griewank", "absolute", 2.0, 1.5, 0.0871, 0.0831),
    _real("Rastrigin", "absolute", 0.4, 5.0, 0.1627, 0.1695),
    _real("Rosenbrock", "absolute", 0.2, 5.5, 8.15e-5, 4.72e-5),
    _real("Schwefel", "absolute", 1.0, 1.5, 2010.5, 2021.0),
    _real("Ackley", "absolute", 0.4, 6.0, 0.2450, 0.0477),
    _real2("Rosenbrock", "relative", 2.0, 4.0, 5, 2, "factorial", 3.96e-5, 1.37e-5),
    _real2("Rosenbrock", "relative", 2.0, 4.5, 10, 2, "geometric", 1.41e-4, 1.10e-6),
    _real2("Griewank", "range", 0.01, 3.5, 5, 4, "factorial", 2.11e-3, 2.17e-4),
    _real2("Griewank", "range", 0.01, 4.0, 10, 10, "geometric", 0.0333, 0.0344),
    _real2("Rosenbrock", "range", 0.001, 4.5, 5, 1, "factorial", 3.70e-7, 3.50e-9),
    _real2("Rosenbrock", "range", 0.001, 4.5, 5, 2, "geometric", 2.22e-7, 3.32e-9),
    _real2("Ackley", "range", 0.1, 5.0, 10, 4, "factorial", 1.59e-9, 1.43e-9),
    _real2("Ackley", "range", 0.1, 4.5, 10, 10, "geometric", 5.33e-8, 5.00e-8),
    _real2("Ackley", "absolute", 2.0, 5.0, 10, 4, "factorial", 6.23e-10, 4.90e-10),
    _real2("Ackley", "absolute", 2.0, 5.0, 10, 10, "geometric", 1.34e-8, 1.34e-8),
    *_bits(
        MGEOCanonical,
        [1.25, 1.0, 1.25, 0.75, 3.25],
        ("Griewank", 0.1151, 0.1198),
        ("Rastrigin", 19.10, 17.99),
        ("Rosenbrock", 5.77e-5, 3.61e-5),
        ("Schwefel", 583.0, 547.2),
        ("Ackley", 0.3552, 4.12e-3),
    ),
    *_bits(
        MGEOVar,
        [2.75, 1.75, 1.5, 1.5, 2.25],
        ("Griewank", 9.23e-3, 6.42e-3),
        ("Rastrigin", 8.88, 9.08),
        ("Rosenbrock", 4.14e-5, 2.94e-5),
        ("Schwefel", 158.2, 159.5),
        ("Ackley", 0.1019, 6.87e-3),
    ),
    *_bits(
        MGEOCanonical,
        "a-geo1",
        ("Griewank", 0.4186, 0.4291),
        ("Rastrigin", 21.26, 21.24),
        ("Rosenbrock", 1.25e-4, 1.00e-4),
        ("Schwefel", 657.0, 678.9),
        ("Ackley", 0.4024, 5.09e-3),
    ),
    *_bits(
        MGEOCanonical,
        "a-geo2",
        ("Griewank", 0.0960, 0.0846),
        ("Rastrigin", 16.23, 15.85),
        ("Rosenbrock", 4.25e-5, 2.73e-5),
        ("Schwefel", 512.6, 546.5),
        ("Ackley", 0.4265, 4.97e-3),
    ),
    *_bits(
        MGEOVar,
        "a-geo2",
        ("Griewank", 0.2334, 0.1895),
        ("Rastrigin", 23.54, 22.14),
        ("Rosenbrock", 0.6346, 0.1304),
        ("Schwefel", 943.9, 917.6),
        ("Ackley", 1.379, 1.646),
    ),
    _real("Griewank", "range", 0.005, "a-geo2", 0.1799, 0.1759),
    _real("Rastrigin", "range", 0.03, "a-geo2", 6.48, 6.68),
    _real("Rosenbrock", "range", 0.005, "a-geo2", 7.49e-6, 5.39e-6),
    _real("Schwefel", "range", 0.09, "a-geo2", 358.9, 348.9),
    _real("Ackley", "range", 0.01, "a-geo2", 0.1864, 0.1903),
    _real2("Griewank", "range", 0.01, "a-geo2", 10, 10, "geometric", 0.0153, 0.0148),
    _real2("Rosenbrock", "range", 0.001, "a-geo2", 5, 2, "geometric", 1.24e-5, 2.19e-8),
    _real2("Ackley", "range", 0.1, "a-geo2", 10, 10, "geometric", 2.80e-8, 2.82e-8),
)
