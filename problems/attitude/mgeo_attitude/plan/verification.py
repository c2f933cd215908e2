"""Whether a plan achieves what its covariance promises: simulated flights, judged by chance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.stats import chi2

from ..estimation import simulate
from ..observability import States
from .plan import ManeuverPlan

#: Probability of calling a filter wrong that is right, for each of the two tests.
SIGNIFICANCE = 0.01


@dataclass(frozen=True, eq=False)
class Verification:
    """Errors of simulated flights at a plan's `t_end` against its prediction.

    Attributes
    ----------
    n_runs : int
    table : DataFrame
        One row per state: ``unit``; ``predicted`` 1-sigma; ``rms`` error of the flights; ``rms /
        predicted [-]``; ``within 3 sigma [%]`` of what each flight's own filter claims.
    greatest_ratio : float
        Ratio that none of the states exceeds by chance, but once in 1 / `SIGNIFICANCE` times.
    nees : float
        Mean normalized error squared per state, eᵀ P⁻¹ e / n_states; 1 for a consistent filter.
    nees_bounds : tuple of two floats
        Between which it lies, but once in 1 / `SIGNIFICANCE` times.
    path_limits : DataFrame
        How often each path limit was truly broken; see `MonteCarlo.broken_limits`.
    """

    n_runs: int
    table: pd.DataFrame
    greatest_ratio: float
    nees: float
    nees_bounds: tuple[float, float]
    path_limits: pd.DataFrame

    @property
    def worse(self) -> list[str]:
        """States whose error is larger than promised, beyond chance."""
        ratio = self.table["rms / predicted [-]"]
        return [str(state) for state in ratio.index[ratio > self.greatest_ratio]]

    @property
    def achieved(self) -> bool:
        """Whether no state is worse than promised, and the filter no surer than it may be."""
        return not self.worse and self.nees <= self.nees_bounds[1]


def verify(plan: ManeuverPlan, n_runs: int = 200, seed: int = 1) -> Verification:
    """Fly a plan `n_runs` times with other errors each time; see `estimation.simulate`.

    Raises
    ------
    ValueError
        For fewer than two runs, or a seed below zero.
    """
    for name, value, least in (("n_runs", n_runs, 2), ("seed", seed, 0)):
        if value < least:
            raise ValueError(f"{name} = {value!r}: expected at least {least}")
    flights = simulate(
        plan.scenario, plan.design, n_runs, seed, environment=plan.problem.environment
    )
    found = flights.table()
    states = States.of(plan.problem.model.suite)
    table = pd.DataFrame(
        {
            "unit": states.units,
            "predicted": found["predicted"].to_numpy() * states.factors,
            "rms": found["rms"].to_numpy() * states.factors,
            "rms / predicted [-]": found["ratio"].to_numpy(),
            "within 3 sigma [%]": 100.0 * found["within 3 sigma"].to_numpy(),
        },
        index=pd.Index(states.names, name="state"),
    )
    count = n_runs * len(table)
    low, high = chi2.ppf([0.5 * SIGNIFICANCE, 1.0 - 0.5 * SIGNIFICANCE], count) / count
    return Verification(
        n_runs=n_runs,
        table=table,
        greatest_ratio=float(np.sqrt(chi2.isf(SIGNIFICANCE / len(table), n_runs) / n_runs)),
        nees=float(flights.nees[:, flights.sample()].mean() / len(table)),
        nees_bounds=(float(low), float(high)),
        path_limits=flights.broken_limits(),
    )
