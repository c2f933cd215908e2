"""Whether an estimator's errors are what it says they are, by chi-square tests."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from scipy.stats import binom, chi2

from mgeo_calibration.estimation.monte_carlo import MonteCarlo

#: Probability that a Gaussian error is beyond three times its 1-sigma.
_BEYOND_3_SIGMA = 0.0026997960632601866


@dataclass(frozen=True)
class Criterion:
    """A statistic and the interval it should be in."""

    name: str
    value: float
    low: float
    high: float

    @property
    def passed(self) -> bool:
        """Whether it is; a NaN is not."""
        return self.low <= self.value <= self.high


@dataclass(frozen=True)
class Consistency:
    """Conclusions from a Monte Carlo simulation, criterion by criterion."""

    criteria: tuple[Criterion, ...]

    @property
    def passed(self) -> bool:
        return all(criterion.passed for criterion in self.criteria)

    def __getitem__(self, name: str) -> Criterion:
        """The criterion of a name; KeyError if there is none."""
        return {criterion.name: criterion for criterion in self.criteria}[name]

    def table(self) -> pd.DataFrame:
        """One row a criterion: ``value``, ``low``, ``high``, ``passed``."""
        rows = [(c.value, c.low, c.high, c.passed) for c in self.criteria]
        names = pd.Index([c.name for c in self.criteria], name="criterion")
        return pd.DataFrame(rows, index=names, columns=["value", "low", "high", "passed"])


def consistency(
    result: MonteCarlo,
    *,
    since: float | None = None,
    confidence: float = 0.99,
    ratio: tuple[float, float] = (0.85, 1.15),
) -> Consistency:
    """Test a simulation from a time on.

    - ``nees``: mean per state over runs and samples, within the chi-square bounds of as many
      degrees of freedom as there are runs times states: errors at different times of a run are
      hardly independent.
    - ``nis <sensor>``: mean per component over all innovations, which are independent, within
      their chi-square bounds; left out for a sensor that measured nothing.
    - ``beyond 3 sigma``: the most runs in which a state's last error is beyond three times the
      1-sigma that the estimator claims, against the binomial bound for the worst of all states.
    - ``smallest`` and ``largest rms / predicted`` of all states: RMS error over runs and samples
      to the linear covariance's 1-sigma. Its interval is asked for, not statistical; with 200 runs
      a single RMS is known to 5 % (1-sigma).

    Parameters
    ----------
    since : float, optional
        Start of the tested samples [s]; default: half of the simulated time.
    confidence : float
        Probability of each statistical interval.
    ratio : (low, high)
        What rms / predicted is to be within.

    Raises
    ------
    ValueError
        If there is no sample from `since` on, or the confidence is no probability.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import consistency, simulate
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 400.0})
    >>> design = [0.5, 0.3, -0.2, 100.0, -0.3, 0.6, 0.2, 100.0, 0.2, -0.4, 0.7, 100.0]
    >>> result = simulate(scenario, design, n_runs=4, seed=1)
    >>> consistency(result, since=200.0).table().index.to_list()[:3]
    ['nees', 'nis sun', 'nis mag']
    """
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence = {confidence!r}: expected a number in (0, 1)")
    start = 0.5 * float(result.times[-1]) if since is None else since
    tested = result.times >= start
    if not tested.any():
        raise ValueError(f"since = {since!r}: expected at most {float(result.times[-1])!r} s")

    def mean_square(name: str, value: float, dof: int) -> Criterion:
        tail = 0.5 * (1.0 - confidence)
        return Criterion(name, value, *(float(chi2.ppf(p, dof) / dof) for p in (tail, 1 - tail)))

    n = result.n_runs * result.n_states
    nees = float(result.nees[:, tested].mean() / result.n_states)
    criteria = [mean_square("nees", nees, n)]
    for index, sensor in enumerate(result.sensors):
        count = result.numbers[index] * int(result.updates[:, tested, index].sum())
        if count:
            nis = float(result.nis[:, tested, index].sum() / count)
            criteria.append(mean_square(f"nis {sensor}", nis, count))
    beyond = (np.abs(result.errors[:, -1]) > 3.0 * result.sigma[:, -1]).sum(axis=0).max()
    most = binom.ppf(confidence ** (1.0 / result.n_states), result.n_runs, _BEYOND_3_SIGMA)
    criteria.append(Criterion("beyond 3 sigma", float(beyond), 0.0, float(most)))
    ratios = rms_ratio(result, tested)
    criteria.append(Criterion("smallest rms / predicted", float(ratios.min()), *ratio))
    criteria.append(Criterion("largest rms / predicted", float(ratios.max()), *ratio))
    return Consistency(tuple(criteria))


def rms_ratio(result: MonteCarlo, tested: np.ndarray) -> Floats:
    """RMS error to predicted 1-sigma of every state over the chosen samples, shape (n_states,)."""
    achieved = (result.errors[:, tested] ** 2).mean(axis=(0, 1))
    ratio: Floats = np.sqrt(achieved / (result.predicted[tested] ** 2).mean(axis=0))
    return ratio
