"""Verification of the predicted accuracy of a plan in Monte Carlo runs, with statistical tests and
suggestions.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.geometry.rotation import rotation_matrix
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.scenario.validity import find_validity_violations
from mgeo_attitude.view.observability.covariance import StateLabels
from scipy.stats import chi2

from mgeo._text import format_duration
from mgeo.studies.statistics import holm_correction
from mgeo_calibration.simulation.monte_carlo import MonteCarloResult
from mgeo_calibration.simulation.simulate import simulate
from mgeo_calibration.simulators.plan_comparison import summarize_gyro_guidance

#: Probability that at least one of all tests rejects a valid plan and filter.
SIGNIFICANCE_LEVEL = 0.01
#: Power at which `Verification.detectable_ratio` is stated.
DETECTION_POWER = 0.9

PREDICTED_RATIO, FILTER_RATIO = "rms / predicted [-]", "rms / filter 1-sigma [-]"
_P_COLUMNS = {PREDICTED_RATIO: "p, predicted", FILTER_RATIO: "p, filter"}


@dataclass(frozen=True, eq=False)
class Verification:
    """Result of verifying a plan in Monte Carlo runs: actual errors, predicted errors and
    statistical tests.

    The verification is one test at the level `SIGNIFICANCE_LEVEL`. It requires that no state error
    exceeds the prediction, that no state error exceeds the filter's 1-sigma, and that the filter
    covariance as a whole, including its correlations, is not too small (NEES). The chi-square
    p-values are corrected by Holm's method over all tests.

    Attributes
    ----------
    n_runs : int
    table : DataFrame
        One row per state: ``unit``; ``predicted`` 1-sigma, see `compute_predictions`, and ``rms``
        error, both root mean squares over the runs; ratio of the error to the prediction and to the
        filter's 1-sigma, root mean squares; ``within 3 sigma [%]`` of the filter's 1-sigma; and the
        corrected p-values of both ratios.
    nees : float
        Mean normalized estimation error squared per state, eᵀ P⁻¹ e / n_states; 1 for a consistent
        filter.
    nees_p : float
        Corrected p-value of `nees`.
    path_constraints : DataFrame
        Violations of path constraints; see `MonteCarloResult.build_violation_table`.
    gyro_guidance : DataFrame
        Pointing errors and constraints with gyro-based guidance; see `summarize_gyro_guidance`.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan
    >>> from mgeo_calibration import verify
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 800.0})
    >>> design = [0.5, 0.3, -0.2, 100.0, -0.3, 0.6, 0.2, 100.0, 0.2, -0.4, 0.7, 100.0]
    >>> plan = ManeuverPlan(scenario, design)
    >>> verify(plan, n_runs=4).table.columns[:4].to_list()
    ['unit', 'predicted', 'rms', 'rms / predicted [-]']
    """

    n_runs: int
    table: pd.DataFrame
    nees: float
    nees_p: float
    path_constraints: pd.DataFrame
    gyro_guidance: pd.DataFrame = field(default_factory=pd.DataFrame)

    @property
    def states_above_prediction(self) -> list[str]:
        """Names of the states with errors significantly larger than predicted by the plan."""
        return self._list_significant_states(PREDICTED_RATIO)

    @property
    def overconfident_states(self) -> list[str]:
        """Names of the states with errors significantly larger than the 1-sigma of the filter."""
        return self._list_significant_states(FILTER_RATIO)

    @property
    def is_achieved(self) -> bool:
        """True if neither a state error nor the NEES is significantly too large."""
        return (
            not (self.states_above_prediction or self.overconfident_states)
            and self.nees_p >= SIGNIFICANCE_LEVEL
        )

    @property
    def max_ratio(self) -> float:
        """Largest ratio of actual error to 1-sigma with which a state passes the tests."""
        return float(np.sqrt(chi2.isf(self._level, self.n_runs) / self.n_runs))

    @property
    def max_nees(self) -> float:
        """Largest NEES per state with which the filter passes the consistency test."""
        n = self.n_runs * len(self.table)
        return float(chi2.isf(self._level, n) / n)

    @property
    def _level(self) -> float:
        """Significance level for the first hypothesis that Holm's procedure does not reject."""
        p = [*self.table[list(_P_COLUMNS.values())].to_numpy().ravel(), self.nees_p]
        n_failed = int(np.sum(np.array(p) < SIGNIFICANCE_LEVEL))
        return SIGNIFICANCE_LEVEL / max(len(p) - n_failed, 1)

    def find_failed_states(self) -> list[str]:
        """Return the names of the states that fail the test against the prediction or the filter
        1-sigma.
        """
        return list(dict.fromkeys([*self.states_above_prediction, *self.overconfident_states]))

    def find_worst_axes(self) -> list[str]:
        """Return the worst axis of each three-axis state, largest error ratio first."""
        worst = self.table[[PREDICTED_RATIO, FILTER_RATIO]].max(axis=1)
        by_block = worst.groupby(lambda state: state.rpartition(" ")[0])
        return list(worst[by_block.idxmax()].sort_values(ascending=False).index)

    @property
    def detectable_ratio(self) -> float:
        """Smallest ratio of actual error to 1-sigma that the runs detect with probability
        `DETECTION_POWER`.
        """
        tests = 2 * len(self.table) + 1
        smallest = chi2.isf(SIGNIFICANCE_LEVEL / tests, self.n_runs) / chi2.isf(
            DETECTION_POWER, self.n_runs
        )
        return float(np.sqrt(smallest))

    def _list_significant_states(self, ratio: str) -> list[str]:
        p = self.table[_P_COLUMNS[ratio]]
        return [str(state) for state in p.index[p < SIGNIFICANCE_LEVEL]]


def verify(plan: ManeuverPlan, n_runs: int = 200, seed: int = 1) -> Verification:
    """Test in Monte Carlo runs whether a plan achieves its predicted accuracy at its convergence
    time.

    `simulation.simulate` describes the simulation of the runs.

    Parameters
    ----------
    plan : ManeuverPlan
    n_runs : int
        Number of Monte Carlo runs, at least 2.
    seed : int
        Seed of the random errors, at least 0.

    Returns
    -------
    Verification

    Raises
    ------
    ValueError
        If there are fewer than two runs.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan
    >>> from mgeo_calibration import verify
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 800.0})
    >>> design = [0.5, 0.3, -0.2, 100.0, -0.3, 0.6, 0.2, 100.0, 0.2, -0.4, 0.7, 100.0]
    >>> plan = ManeuverPlan(scenario, design)
    >>> verify(plan, n_runs=4).n_runs
    4
    """
    if n_runs < 2:
        raise ValueError(f"n_runs = {n_runs!r}: expected at least 2")
    runs = simulate(
        plan.scenario,
        plan.design,
        n_runs,
        seed,
        environment=plan.problem.environment,
        end_time=plan.t_end,
    )
    result, at = runs.build_table(), runs.find_sample()
    states = StateLabels.from_suite(plan.problem.model.suite)
    prediction = compute_predictions(plan, runs)
    predicted, filter_ratio = (
        np.sqrt(((runs.errors[:, at] / sigma) ** 2).mean(axis=0))
        for sigma in (prediction, runs.sigma[:, at])
    )
    nees, m = float(runs.nees[:, at].mean() / len(states.names)), len(states.names)
    p = holm_correction(
        np.concatenate(
            [
                chi2.sf(n_runs * np.concatenate([predicted, filter_ratio]) ** 2, n_runs),
                chi2.sf([n_runs * m * nees], n_runs * m),
            ]
        )
    )
    table = pd.DataFrame(
        {
            "unit": states.units,
            "predicted": np.sqrt((prediction**2).mean(axis=0)) * states.factors,
            "rms": result["rms"].to_numpy() * states.factors,
            PREDICTED_RATIO: predicted,
            FILTER_RATIO: filter_ratio,
            "within 3 sigma [%]": 100.0 * result["within 3 sigma"].to_numpy(),
            _P_COLUMNS[PREDICTED_RATIO]: p[:m],
            _P_COLUMNS[FILTER_RATIO]: p[m:-1],
        },
        index=pd.Index(states.names, name="state"),
    )
    violations, where = runs.build_violation_table(), summarize_gyro_guidance(plan, n_runs, seed)
    return Verification(n_runs, table, nees, float(p[-1]), violations, where)


def compute_predictions(plan: ManeuverPlan, runs: MonteCarloResult) -> Floats:
    """Return the predicted 1-sigma of each state at the convergence time, one row per Monte Carlo
    run.

    The prediction is the linear covariance of the plan, equal in all runs. For magnetorquers it is
    the linear covariance of the motion of each run, which depends on the initial attitude.

    Returns
    -------
    array, shape (n_runs, n_states)
        In the units of the filter.
    """
    model, at = plan.problem.model, runs.find_sample()
    if not plan.scenario.is_magnetorquer_driven:
        return np.broadcast_to(runs.predicted_sigma[at], runs.errors[:, at].shape)
    first, step = model.initial_attitude, round(plan.t_end / model.step)
    result = []
    for error in runs.errors[:, 0, :3]:
        true_model = model.rotate_initial_attitude(first.T @ rotation_matrix(error) @ first)
        run = evaluate(true_model, [plan.design], 1, covariance=True, end_steps=step)
        result.append(np.sqrt(np.diag(run.covariance[0])))
    return np.array(result)


def format_conclusion(verification: Verification) -> str:
    """Describe in one sentence whether the plan achieves its predicted accuracy.

    The sentence states the largest error ratio or the worst failure.
    """
    runs = f"over {verification.n_runs} Monte Carlo runs"
    if failures := describe_failures(verification):
        n_more = len(failures) - 1
        more = f"; {n_more} more quantities fail" if n_more else ""
        return f"The plan does not achieve its predicted accuracy: {runs}, {failures[0]}{more}."
    ratio = verification.table[PREDICTED_RATIO]
    return (
        f"The plan achieves its predicted accuracy: {runs}, the largest rms error is "
        f"{ratio.max():.2f} times its predicted 1-sigma ({ratio.idxmax()}); ratios up "
        f"to {verification.max_ratio:.2f} pass."
    )


def describe_failures(verification: Verification) -> list[str]:
    """Return one line of text for each state whose error is too large, largest ratio first.

    Each line states the error ratio of a three-axis state and whether the filter is overconfident.
    If only the NEES fails, the result is one line on the filter as a whole.
    """
    lines = []
    blocks: dict[str, list[str]] = {
        state.rpartition(" ")[0]: [] for state in verification.find_worst_axes()
    }
    for state in verification.find_failed_states():
        blocks[state.rpartition(" ")[0]].append(state)
    for block, states in blocks.items():
        if not states:
            continue
        predicted, filter_ratio = (
            verification.table.loc[states, ratio].max() for ratio in (PREDICTED_RATIO, FILTER_RATIO)
        )
        axes = ", ".join(state.rpartition(" ")[2] for state in states)
        is_overconfident = any(state in verification.overconfident_states for state in states)
        filter_note = (
            f"the filter is overconfident by a factor of {filter_ratio:.2f}"
            if is_overconfident
            else "the 1-sigma of the filter covers the error"
        )
        lines.append(
            f"the rms error of the {block} ({axes}) is {predicted:.2f} times its predicted "
            f"1-sigma, and {filter_note}"
        )
    if not lines and verification.nees_p < SIGNIFICANCE_LEVEL:
        factor = math.sqrt(verification.nees)
        lines.append(
            f"the filter is overconfident by a factor of {factor:.2f} over all states together"
        )
    return lines


def describe_power(verification: Verification) -> str:
    """Describe the power of the statistical tests and their false-alarm probability.

    The power is stated as the error ratio that the runs detect.
    """
    return (
        f"Power of the test: a plan whose actual 1-sigma is {verification.detectable_ratio:.2f} "
        f"times the predicted one fails with a probability of {100.0 * DETECTION_POWER:.0f} %, and "
        f"a valid plan with a probability of {100.0 * SIGNIFICANCE_LEVEL:.0f} %."
    )


def list_suggestions(plan: ManeuverPlan, verification: Verification) -> Iterator[str]:
    """Yield suggestions for a plan that misses its predicted accuracy, most effective first."""
    if verification.is_achieved:
        return
    scenario, outside = plan.scenario, find_validity_violations(plan.scenario)
    if outside:
        yield f"Reduce the initial uncertainty ({'; '.join(outside)})."
    elif scenario.prior is None:
        known = f"initial.attitude_deg = {scenario.initial.attitude_deg:g}"
        yield f"Reduce the initial uncertainty, for example of the attitude ({known})."
    if plan.t_end < scenario.duration:
        yield (
            f"Choose a plan that ends later than {format_duration(plan.t_end)}, with --pick "
            "min-trace or --time SECONDS. The effect of the first, nonlinear updates then decays."
        )
    yield (
        "Choose other settings of the on-board filter: the documentation on filter consistency "
        "compares Jacobians at the estimate, covariance reset and second-order updates."
    )
    yield (
        "Accept a lower accuracy: multiply the predicted 1-sigma by the ratio in its row, or set "
        "required_sigma with a margin."
    )
