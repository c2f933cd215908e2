"""Design vectors as a pymoo population, at half the cost of `Population.new`."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymoo.core.individual import Individual
from pymoo.core.population import Population


def individuals(X: NDArray[Any]) -> Population:
    """New individuals at (n, n_var) design vectors, or (n,) of them that are objects.

    They are copies of one blank individual, whose configuration they share: most of what the
    constructor spends goes into a configuration of its own for each, and the memory and garbage
    collection of that. Each has its own copy of its design, so that an archive which keeps few of
    a batch does not keep the batch.
    """
    blank = vars(Individual())
    population = np.empty(len(X), dtype=object).view(Population)
    for i, design in enumerate(X):
        individual = population[i] = Individual.__new__(Individual)
        own = design.copy() if isinstance(design, np.ndarray) else design
        vars(individual).update(blank, _X=own, data={}, evaluated=set())
    return population
