"""Results of Monte Carlo runs, and consistency tests of their errors with the filter covariance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats, Ints
from scipy.stats import binom, chi2

_AXES = ("x", "y", "z")
#: Probability that a Gaussian error exceeds three times its 1-sigma.
_BEYOND_3_SIGMA = 0.0026997960632601866


@dataclass(frozen=True, eq=False, kw_only=True)
class RunStatistics:
    """Estimation errors and filter statistics of n runs at m samples.

    See `MonteCarloResult` for the shapes of the arrays.
    """

    errors: Floats
    sigma: Floats
    nees: Floats
    nis: Floats
    n_innovations: Ints
    violated_fractions: Floats


@dataclass(frozen=True, eq=False, kw_only=True)
class MonteCarloResult(RunStatistics):
    """Estimation errors and filter statistics of n Monte Carlo runs of one plan at m samples.

    Errors are truth minus estimate in the filter's units: rad, rad/s, dimensionless, and 50 µT for
    the field. Errors of attitude and misalignments are rotation vectors.

    Attributes
    ----------
    blocks : tuple of str
        Names of the state blocks, each a 3-vector.
    sensors : tuple of str
        Names of the sensors.
    n_components : tuple of int
        Number of components of each sensor.
    design : array, shape (4 k,)
        Design of the plan.
    t_end : float
        Predicted convergence time, first objective of equation (5) [s]; one of the samples.
    times : array, shape (m,)
        Times of the samples [s].
    predicted_sigma : array, shape (m, n_states)
        1-sigma predicted by the linear covariance of the plan.
    errors : array, shape (n, m, n_states)
        Estimation errors.
    sigma : array, shape (n, m, n_states)
        1-sigma of the filter in each run.
    nees : array, shape (n, m)
        Normalized estimation error squared, eᵀ P⁻¹ e; its expected value is n_states.
    nis : array, shape (n, m, n_sensors)
        Sum of the normalized innovations squared, rᵀ S⁻¹ r, since the previous sample.
    n_innovations : array of int, shape (n, m, n_sensors)
        Number of innovations in `nis`; the expected value of each is the number of components.
    path_constraints : tuple of str
        Labels of the path constraints, such as ``Sun off camera``.
    violated_fractions : array, shape (n, 2, n_path_constraints)
        Fraction of the time until `t_end` in which each constraint is violated, steered and open
        loop; see `build_violation_table`.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import simulate
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 400.0})
    >>> design = [0.5, 0.3, -0.2, 100.0, -0.3, 0.6, 0.2, 100.0, 0.2, -0.4, 0.7, 100.0]
    >>> result = simulate(scenario, design, n_runs=4, seed=1)
    >>> result.build_table().columns.to_list()[:4]
    ['predicted', 'filter', 'rms', 'ratio']
    """

    blocks: tuple[str, ...]
    sensors: tuple[str, ...]
    n_components: tuple[int, ...]
    design: Floats
    t_end: float
    times: Floats
    predicted_sigma: Floats
    path_constraints: tuple[str, ...]

    @property
    def n_runs(self) -> int:
        return len(self.errors)

    @property
    def n_states(self) -> int:
        return 3 * len(self.blocks)

    @property
    def states(self) -> tuple[str, ...]:
        """Names of all states, such as ``attitude.x``."""
        return tuple(f"{block}.{axis}" for block in self.blocks for axis in _AXES)

    @property
    def rms(self) -> Floats:
        """Root-mean-square estimation error over the runs, shape (m, n_states)."""
        rms: Floats = np.sqrt((self.errors**2).mean(axis=0))
        return rms

    def find_sample(self, time: float | None = None) -> int:
        """Return the index of the recorded sample that is closest to a given time.

        Parameters
        ----------
        time : float, optional
            Time [s]; default: `t_end`.
        """
        return int(np.argmin(np.abs(self.times - (self.t_end if time is None else time))))

    def build_table(self, time: float | None = None) -> pd.DataFrame:
        """Build a table of the predicted and actual errors of each state at a given time.

        Columns in the filter's units: ``predicted``, 1-sigma of the linear covariance; ``filter``,
        rms over the runs of the filter's 1-sigma; ``rms`` error; ``ratio`` of rms error to
        predicted; ``within 3 sigma``, fraction of runs with an error within three times the
        filter's 1-sigma.

        Parameters
        ----------
        time : float, optional
            Time [s]; default: `t_end`.

        Returns
        -------
        DataFrame
            One row per state.
        """
        k = self.find_sample(time)
        rms = self.rms[k]
        return pd.DataFrame(
            {
                "predicted": self.predicted_sigma[k],
                "filter": np.sqrt((self.sigma[:, k] ** 2).mean(axis=0)),
                "rms": rms,
                "ratio": rms / self.predicted_sigma[k],
                "within 3 sigma": (np.abs(self.errors[:, k]) <= 3.0 * self.sigma[:, k]).mean(0),
            },
            index=pd.Index(self.states, name="state"),
        )

    def build_violation_table(self) -> pd.DataFrame:
        """Build a table that shows how many runs violate each path constraint until `t_end`, and
        for how long.

        The constraints are evaluated without margin.

        Two cases are evaluated. *Steered*: a controller keeps the estimated attitude on the plan,
        so that the true attitude is off by the estimation error before the measurements of the
        sample. *Open loop*: the rates of the plan are executed exactly, as in the simulation, so
        that the initial attitude error remains. The estimation errors of both cases come from the
        open-loop run and differ only to second order.

        Returns
        -------
        DataFrame
            One row per constraint. Columns: percentage of runs with a violation, and percentage of
            the time of all runs.
        """
        run_fractions, time_fractions = (
            (self.violated_fractions > 0.0).mean(axis=0),
            self.violated_fractions.mean(axis=0),
        )
        columns = {}
        for i, case in enumerate(("steered", "open loop")):
            columns[f"{case}: runs [%]"] = 100.0 * run_fractions[i]
            columns[f"{case}: time [%]"] = 100.0 * time_fractions[i]
        return pd.DataFrame(columns, index=pd.Index(self.path_constraints, name="path constraint"))

    def build_history(self) -> pd.DataFrame:
        """Build a table of the mean normalized errors squared (NEES) and innovations squared (NIS)
        at each sample.

        Columns: ``nees`` per state and ``nis <sensor>`` per component. The expected value is 1.
        Samples without innovations since the previous sample are NaN.
        """
        columns = {"nees": self.nees.mean(axis=0) / self.n_states}
        total, count = self.nis.sum(axis=0), self.n_innovations.sum(axis=0) * self.n_components
        with np.errstate(invalid="ignore"):
            per_component = total / count
        for index, sensor in enumerate(self.sensors):
            columns[f"nis {sensor}"] = per_component[:, index]
        return pd.DataFrame(columns, index=pd.Index(self.times, name="time [s]"))


def evaluate_consistency(
    result: MonteCarloResult,
    *,
    start_time: float | None = None,
    confidence: float = 0.99,
    ratio_bounds: tuple[float, float] = (0.85, 1.15),
) -> pd.DataFrame:
    """Test whether the errors of Monte Carlo runs are statistically consistent with the filter
    covariance.

    - ``nees``: mean per state over runs and samples. The chi-square interval has runs times states
      degrees of freedom, because errors at different times of a run are strongly correlated.
    - ``nis <sensor>``: mean per component over all innovations, with their chi-square interval. A
      sensor without readings has no such row.
    - ``beyond 3 sigma``: largest number of runs in which the last error of a state exceeds three
      times the filter's 1-sigma, with the binomial bound for the worst of all states.
    - ``smallest`` and ``largest rms / predicted``: extreme ratio over the states of the rms error
      over runs and samples to the predicted 1-sigma. The interval is a requirement, not a
      statistical bound; with 200 runs the 1-sigma of a single rms is 5 %.

    Parameters
    ----------
    result : MonteCarloResult
    start_time : float, optional
        Start of the tested samples [s]; default: half of the simulated time.
    confidence : float
        Probability of each statistical interval.
    ratio_bounds : (low, high)
        Required interval of rms / predicted.

    Returns
    -------
    DataFrame
        One row per criterion: ``value``, interval ``low`` to ``high``, and ``passed``.

    Raises
    ------
    ValueError
        If there is no sample from `start_time` on, or the confidence is not a probability.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import evaluate_consistency, simulate
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 400.0})
    >>> design = [0.5, 0.3, -0.2, 100.0, -0.3, 0.6, 0.2, 100.0, 0.2, -0.4, 0.7, 100.0]
    >>> result = simulate(scenario, design, n_runs=4, seed=1)
    >>> evaluate_consistency(result, start_time=200.0).index.to_list()[:3]
    ['nees', 'nis sun', 'nis mag']
    """
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence = {confidence!r}: expected a number in (0, 1)")
    start = 0.5 * float(result.times[-1]) if start_time is None else start_time
    is_tested = result.times >= start
    if not is_tested.any():
        raise ValueError(
            f"start_time = {start_time!r}: expected at most {float(result.times[-1])!r} s"
        )

    tail = 0.5 * (1.0 - confidence)

    def compute_interval(degrees_of_freedom: int) -> tuple[float, float]:
        low, high = chi2.ppf([tail, 1.0 - tail], degrees_of_freedom) / degrees_of_freedom
        return float(low), float(high)

    nees = result.nees[:, is_tested].mean() / result.n_states
    rows = {"nees": (nees, *compute_interval(result.n_runs * result.n_states))}
    for index, sensor in enumerate(result.sensors):
        count = result.n_components[index] * int(result.n_innovations[:, is_tested, index].sum())
        if count:
            rows[f"nis {sensor}"] = (
                result.nis[:, is_tested, index].sum() / count,
                *compute_interval(count),
            )
    n_beyond = (np.abs(result.errors[:, -1]) > 3.0 * result.sigma[:, -1]).sum(axis=0).max()
    max_beyond = binom.ppf(confidence ** (1.0 / result.n_states), result.n_runs, _BEYOND_3_SIGMA)
    rows["beyond 3 sigma"] = float(n_beyond), 0.0, float(max_beyond)
    mean_squares = (result.errors[:, is_tested] ** 2).mean(axis=(0, 1))
    ratios = np.sqrt(mean_squares / (result.predicted_sigma[is_tested] ** 2).mean(axis=0))
    rows["smallest rms / predicted"] = ratios.min(), *ratio_bounds
    rows["largest rms / predicted"] = ratios.max(), *ratio_bounds
    report = pd.DataFrame.from_dict(rows, orient="index", columns=["value", "low", "high"])
    report["passed"] = report["value"].between(report["low"], report["high"])  # False for NaN
    return report.rename_axis("criterion")
