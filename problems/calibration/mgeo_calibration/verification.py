"""Whether a plan achieves what its covariance promises, in numbers and in words."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.geometry.rotation import matrix
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.scenario.validity import validity
from mgeo_attitude.view.describe import span
from mgeo_attitude.view.observability.covariance import States
from scipy.stats import chi2

from mgeo.studies.statistics import holm
from mgeo_calibration.flight.as_flown import ends
from mgeo_calibration.simulation.flights import simulate
from mgeo_calibration.simulation.monte_carlo import MonteCarlo

#: Probability of calling a plan and its filter wrong that are right, in all tests together.
LEVEL = 0.01
#: With which an error that is too large is to be found, to say how large that must be.
POWER = 0.9

PREDICTED, CLAIMED = "rms / predicted [-]", "rms / claimed [-]"
_P = {PREDICTED: "p, predicted", CLAIMED: "p, claimed"}


@dataclass(frozen=True, eq=False)
class Verification:
    """Errors of simulated flights at a plan's `t_end`, against its prediction and their filter.

    It is one test at the `LEVEL`: that no state's error is larger than predicted, that none is
    larger than the filter claims, and that the filter's covariance as a whole, with its
    correlations, is not too small (NEES). Their p-values are chi-square's, corrected by Holm for
    all of them together.

    Attributes
    ----------
    n_runs : int
    table : DataFrame
        One row per state: ``unit``; ``predicted`` 1-sigma, see `predictions`, and ``rms`` error,
        root mean squares of the flights; the ratio of each error to its prediction, and to what
        its own filter claims (root mean squares); ``within 3 sigma [%]`` of the claim; and the two
        ratios' p-values, corrected.
    nees : float
        Mean normalized error squared per state, eᵀ P⁻¹ e / n_states; 1 for a consistent filter.
    nees_p : float
        Its p-value, corrected.
    path_limits : DataFrame
        How often each path limit was truly broken; see `MonteCarlo.broken_limits`.
    ends : DataFrame
        Where flights end that are turned by their gyro, and what they keep; see `ends`.

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
    path_limits: pd.DataFrame
    ends: pd.DataFrame = field(default_factory=pd.DataFrame)

    @property
    def worse(self) -> list[str]:
        """States whose error is larger than predicted, beyond chance."""
        return self._beyond(PREDICTED)

    @property
    def too_sure(self) -> list[str]:
        """States whose error is larger than the filter claims, beyond chance."""
        return self._beyond(CLAIMED)

    @property
    def achieved(self) -> bool:
        """Whether no test fails."""
        return not (self.worse or self.too_sure) and self.nees_p >= LEVEL

    @property
    def detectable(self) -> float:
        """How many times too large an error must be for so many flights to show it with `POWER`."""
        tests = 2 * len(self.table) + 1
        smallest = chi2.isf(LEVEL / tests, self.n_runs) / chi2.isf(POWER, self.n_runs)
        return float(np.sqrt(smallest))

    def _beyond(self, ratio: str) -> list[str]:
        p = self.table[_P[ratio]]
        return [str(state) for state in p.index[p < LEVEL]]


def verify(plan: ManeuverPlan, n_runs: int = 200, seed: int = 1) -> Verification:
    """Fly a plan `n_runs` times, to its `t_end`, with other errors each time.

    See `simulation.simulate`.

    Parameters
    ----------
    plan : ManeuverPlan
    n_runs : int
        From 2.
    seed : int
        From 0.

    Raises
    ------
    ValueError
        For fewer than two runs.

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
    flights = simulate(
        plan.scenario,
        plan.design,
        n_runs,
        seed,
        environment=plan.problem.environment,
        until=plan.t_end,
    )
    found, at = flights.table(), flights.sample()
    states = States.of(plan.problem.model.suite)
    promised = predictions(plan, flights)
    predicted, claimed = (
        np.sqrt(((flights.errors[:, at] / sigma) ** 2).mean(axis=0))
        for sigma in (promised, flights.sigma[:, at])
    )
    nees, m = float(flights.nees[:, at].mean() / len(states.names)), len(states.names)
    p = holm(
        np.concatenate(
            [
                chi2.sf(n_runs * np.concatenate([predicted, claimed]) ** 2, n_runs),
                chi2.sf([n_runs * m * nees], n_runs * m),
            ]
        )
    )
    table = pd.DataFrame(
        {
            "unit": states.units,
            "predicted": np.sqrt((promised**2).mean(axis=0)) * states.factors,
            "rms": found["rms"].to_numpy() * states.factors,
            PREDICTED: predicted,
            CLAIMED: claimed,
            "within 3 sigma [%]": 100.0 * found["within 3 sigma"].to_numpy(),
            _P[PREDICTED]: p[:m],
            _P[CLAIMED]: p[m:-1],
        },
        index=pd.Index(states.names, name="state"),
    )
    broken, where = flights.broken_limits(), ends(plan, n_runs, seed)
    return Verification(n_runs, table, nees, float(p[-1]), broken, where)


def predictions(plan: ManeuverPlan, flights: MonteCarlo) -> Floats:
    """1-sigma of each state at `t_end` that the linear covariance predicts, shape (n, n_states).

    That of the plan flown exactly, for all flights; or for each flight that of the motion that
    coils make of the attitude it begins at.
    """
    model, at = plan.problem.model, flights.sample()
    if not plan.scenario.turned_by_coils:
        return np.broadcast_to(flights.predicted[at], flights.errors[:, at].shape)
    first, step = model.initial_attitude, round(plan.t_end / model.step)
    found = []
    for error in flights.errors[:, 0, :3]:
        flown = model.turned(first.T @ matrix(error) @ first)
        run = evaluate(flown, [plan.design], 1, covariance=True, until=step)
        found.append(np.sqrt(np.diag(run.covariance[0])))
    return np.array(found)


def conclusion(found: Verification) -> str:
    """In one line, whether the plan achieves its prediction, at which level, and the margin."""
    at = f"{found.n_runs} flights, one test at {LEVEL:.0%}"
    if not found.achieved:
        return f"not achieved: {'; '.join(findings(found))} ({at})"
    ratio = found.table[PREDICTED]
    return (
        f"achieved: no error is larger than predicted, the largest {ratio.max():.2f} times its "
        f"1-sigma ({ratio.idxmax()}), nor than the filter claims ({at})"
    )


def findings(found: Verification) -> list[str]:
    """Of each 3-vector of the state that fails: by what factor, and whether the filter knows."""
    lines = []
    blocks: dict[str, list[str]] = {}
    for state in dict.fromkeys([*found.worse, *found.too_sure]):
        blocks.setdefault(state.rpartition(" ")[0], []).append(state)
    for block, states in blocks.items():
        predicted, claimed = (
            found.table.loc[states, ratio].max() for ratio in (PREDICTED, CLAIMED)
        )
        axes = ", ".join(state.rpartition(" ")[2] for state in states)
        sure = any(state in found.too_sure for state in states)
        why = f"the filter is overconfident by {claimed:.2f}" if sure else "the filter knows it"
        lines.append(f"{block} ({axes}) {predicted:.2f} times the predicted 1-sigma, {why}")
    if not lines and found.nees_p < LEVEL:
        factor = math.sqrt(found.nees)
        lines.append(f"the filter is overconfident by {factor:.2f} over all states together")
    return lines


def power(found: Verification) -> str:
    """What so many flights can show."""
    return (
        f"an error {found.detectable:.2f} times too large would be found with {POWER:.0%}, once in "
        f"{1 / LEVEL:.0f} a good plan is called bad"
    )


def remedies(plan: ManeuverPlan, found: Verification) -> Iterator[str]:
    """What to try where a plan fails, the first first; nothing where it does not."""
    if found.achieved:
        return
    scenario, outside = plan.scenario, validity(plan.scenario)
    if outside:
        yield f"know more at the start: {'; '.join(outside)}"
    elif scenario.prior is None:
        known = f"initial.attitude_deg, {scenario.initial.attitude_deg:g} here"
        yield f"know more at the start, such as the attitude ({known})"
    if plan.t_end < scenario.duration:
        yield (
            f"a plan that converges later than {span(plan.t_end)}: --pick best, or --time SECONDS; "
            "the first updates are forgotten by then"
        )
    yield (
        "another estimator on board: docs/consistency.md compares its options (Jacobians at the "
        "estimate, reset, second order)"
    )
    yield (
        "a wider requirement: multiply the predicted 1-sigma by the ratio of its row, or ask for a "
        "required_sigma that leaves room for it"
    )
