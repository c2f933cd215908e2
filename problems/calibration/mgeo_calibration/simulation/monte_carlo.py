"""What a Monte Carlo simulation gives, and whether its errors are what the filter said of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats, Ints
from scipy.stats import binom, chi2

_AXES = ("x", "y", "z")
#: Probability that a Gaussian error is beyond three times its 1-sigma.
_BEYOND_3_SIGMA = 0.0026997960632601866


@dataclass(frozen=True, eq=False, kw_only=True)
class Record:
    """What is recorded of n runs at m samples; see `MonteCarlo`."""

    errors: Floats
    sigma: Floats
    nees: Floats
    nis: Floats
    updates: Ints
    broken: Floats


@dataclass(frozen=True, eq=False, kw_only=True)
class MonteCarlo(Record):
    """n runs of one plan at m samples, the whole scenario long unless it was told to end before.

    Errors are truth less estimate in the filter's units (rad, rad/s, dimensionless; the field in
    units of 50 µT); those of attitude and misalignments are the vectors of the rotations that
    remain.

    Attributes
    ----------
    blocks : tuple of str
        Names of the state's 3-vectors.
    sensors : tuple of str
    numbers : tuple of int
        How many each sensor measures at a time, up to three.
    design : array, shape (4 k,)
        The plan.
    t_end : float
        When the linear filter has converged, first objective of equation (5) [s]; a sample.
    times : array, shape (m,)
        [s], from 0 to the scenario's duration, or until when it was simulated.
    predicted : array, shape (m, n_states)
        1-sigma that the linear covariance promises for the plan.
    errors : array, shape (n, m, n_states)
    sigma : array, shape (n, m, n_states)
        1-sigma that the estimator of each run claims.
    nees : array, shape (n, m)
        Normalized estimation error squared, eᵀ P⁻¹ e; its mean over runs should be n_states.
    nis : array, shape (n, m, n_sensors)
        Sum of normalized innovations squared, rᵀ S⁻¹ r, since the sample before.
    updates : array of int, shape (n, m, n_sensors)
        Number of innovations in `nis`; the mean of each should be that of its `numbers`.
    path_limits : tuple of str
        Labels of the scenario's path limits: ``Sun off camera``.
    broken : array, shape (n, 2, n_path_limits)
        Share of the time until `t_end` in which each was broken; see `broken_limits`.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import simulate
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 400.0})
    >>> design = [0.5, 0.3, -0.2, 100.0, -0.3, 0.6, 0.2, 100.0, 0.2, -0.4, 0.7, 100.0]
    >>> result = simulate(scenario, design, n_runs=4, seed=1)
    >>> result.table().columns.to_list()[:4]
    ['predicted', 'claimed', 'rms', 'ratio']
    """

    blocks: tuple[str, ...]
    sensors: tuple[str, ...]
    numbers: tuple[int, ...]
    design: Floats
    t_end: float
    times: Floats
    predicted: Floats
    path_limits: tuple[str, ...]

    @property
    def n_runs(self) -> int:
        return len(self.errors)

    @property
    def n_states(self) -> int:
        return 3 * len(self.blocks)

    @property
    def states(self) -> tuple[str, ...]:
        """Name of every state: ``attitude.x``, ``attitude.y``..."""
        return tuple(f"{block}.{axis}" for block in self.blocks for axis in _AXES)

    @property
    def rms(self) -> Floats:
        """Root of the mean square error over the runs, shape (m, n_states)."""
        rms: Floats = np.sqrt((self.errors**2).mean(axis=0))
        return rms

    def sample(self, time: float | None = None) -> int:
        """Number of the sample nearest to a time [s]; `t_end` if none is given."""
        return int(np.argmin(np.abs(self.times - (self.t_end if time is None else time))))

    def table(self, time: float | None = None) -> pd.DataFrame:
        """Every state at a time [s], `t_end` if none is given.

        Columns, in the filter's units: ``predicted``, the linear covariance's 1-sigma;
        ``claimed``, the estimators' (root mean square over the runs); ``rms`` error; ``ratio`` of
        rms error to predicted; ``within 3 sigma``, the fraction of runs whose error is within
        three times what their estimator claims.
        """
        k = self.sample(time)
        rms = self.rms[k]
        return pd.DataFrame(
            {
                "predicted": self.predicted[k],
                "claimed": np.sqrt((self.sigma[:, k] ** 2).mean(axis=0)),
                "rms": rms,
                "ratio": rms / self.predicted[k],
                "within 3 sigma": (np.abs(self.errors[:, k]) <= 3.0 * self.sigma[:, k]).mean(0),
            },
            index=pd.Index(self.states, name="state"),
        )

    def broken_limits(self) -> pd.DataFrame:
        """How often each path limit was truly broken until `t_end`, without margin; a row for each.

        Two satellites are looked at. One is *steered*: its controller turns it until the estimated
        attitude is the plan's, so that the true one is off the plan by the error of the estimate,
        before the measurements of the sample. The other flies the plan's rates *open loop*, as all
        runs here, and keeps the error of its first attitude. The errors of the estimate are those
        of the open-loop run; along the other path they differ by terms of second order.

        Columns: share of flights in which it was broken at any time, and of the time of all.
        """
        ever, share = (self.broken > 0.0).mean(axis=0), self.broken.mean(axis=0)
        columns = {}
        for i, way in enumerate(("steered", "open loop")):
            columns[f"{way}: flights [%]"] = 100.0 * ever[i]
            columns[f"{way}: time [%]"] = 100.0 * share[i]
        return pd.DataFrame(columns, index=pd.Index(self.path_limits, name="path limit"))

    def history(self) -> pd.DataFrame:
        """Every sample: ``nees`` (mean over runs, per state) and ``nis <sensor>`` (per component).

        All should be about 1. A sensor that measured nothing since the sample before has NaN.
        """
        columns = {"nees": self.nees.mean(axis=0) / self.n_states}
        total, count = self.nis.sum(axis=0), self.updates.sum(axis=0) * self.numbers
        with np.errstate(invalid="ignore"):
            per_component = total / count
        for index, sensor in enumerate(self.sensors):
            columns[f"nis {sensor}"] = per_component[:, index]
        return pd.DataFrame(columns, index=pd.Index(self.times, name="time [s]"))


def consistency(
    result: MonteCarlo,
    *,
    since: float | None = None,
    confidence: float = 0.99,
    ratio: tuple[float, float] = (0.85, 1.15),
) -> pd.DataFrame:
    """Test whether the errors of a simulation are what its filter claims, from a time on.

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

    Returns
    -------
    DataFrame
        A row for each criterion: ``value``, the interval from ``low`` to ``high``, and whether the
        value has ``passed``.

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
    >>> consistency(result, since=200.0).index.to_list()[:3]
    ['nees', 'nis sun', 'nis mag']
    """
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence = {confidence!r}: expected a number in (0, 1)")
    start = 0.5 * float(result.times[-1]) if since is None else since
    tested = result.times >= start
    if not tested.any():
        raise ValueError(f"since = {since!r}: expected at most {float(result.times[-1])!r} s")

    tail = 0.5 * (1.0 - confidence)

    def interval(freedom: int) -> tuple[float, float]:
        low, high = chi2.ppf([tail, 1.0 - tail], freedom) / freedom
        return float(low), float(high)

    nees = result.nees[:, tested].mean() / result.n_states
    rows = {"nees": (nees, *interval(result.n_runs * result.n_states))}
    for index, sensor in enumerate(result.sensors):
        count = result.numbers[index] * int(result.updates[:, tested, index].sum())
        if count:
            rows[f"nis {sensor}"] = result.nis[:, tested, index].sum() / count, *interval(count)
    beyond = (np.abs(result.errors[:, -1]) > 3.0 * result.sigma[:, -1]).sum(axis=0).max()
    most = binom.ppf(confidence ** (1.0 / result.n_states), result.n_runs, _BEYOND_3_SIGMA)
    rows["beyond 3 sigma"] = float(beyond), 0.0, float(most)
    achieved = (result.errors[:, tested] ** 2).mean(axis=(0, 1))
    ratios = np.sqrt(achieved / (result.predicted[tested] ** 2).mean(axis=0))
    rows["smallest rms / predicted"] = ratios.min(), *ratio
    rows["largest rms / predicted"] = ratios.max(), *ratio
    found = pd.DataFrame.from_dict(rows, orient="index", columns=["value", "low", "high"])
    found["passed"] = found["value"].between(found["low"], found["high"])  # not so of NaN
    return found.rename_axis("criterion")
