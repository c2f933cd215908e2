"""A verification in words: what is too large or overconfident, and what to do about it."""

from __future__ import annotations

import math
from collections.abc import Iterator

from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.scenario.validity import validity
from mgeo_attitude.view.describe import span

from mgeo_calibration.verification.verification import (
    CLAIMED,
    LEVEL,
    POWER,
    PREDICTED,
    Verification,
)


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


def remedies(plan: ManeuverPlan, found: Verification) -> list[str]:
    """What to try where a plan fails, the first first; empty where it does not."""
    return [] if found.achieved else list(_remedies(plan))


def _remedies(plan: ManeuverPlan) -> Iterator[str]:
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
