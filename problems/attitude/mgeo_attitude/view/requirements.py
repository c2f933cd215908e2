"""What is said of required 1-sigmas: when they are met, and what no turn makes smaller."""

from __future__ import annotations

import dataclasses

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.suite import BlockUnit, block_units
from mgeo_attitude.view.plans import Plans

#: Share of an initial 1-sigma from which on nothing was learned.
_NOTHING = 0.9
#: Share of a variance from which on an error is called its source.
_SOURCE = 0.5


def remarks(plans: Plans, these: str) -> list[str]:
    """Whether plans of a front meet what is required long before they end.

    By the rule ``trace`` a filter goes on until its trace is flat; by ``required`` until it meets
    the requirements for good: near what can be reached they are lost again and again.
    """
    problem, X = plans.problem, plans.X
    scenario, model = problem.scenario, problem.model
    rule = scenario.convergence.rule
    if not scenario.required_sigma or rule in ("settling", "end"):
        return []
    other = "required" if rule == "trace" else "trace"
    by_other = problem.run(X, lambda model: dataclasses.replace(model, rule=other)).t_end
    found = {rule: plans.exactly.t_end, other: by_other}
    trace, required = found["trace"], found["required"]
    if rule == "trace":
        sooner = int((required < trace).sum())
        line = (
            f"{sooner} of {these} meet required_sigma for good before they end, the "
            f"first after {np.nanmin(required):.6g} s, where the fastest ends after "
            f'{np.nanmin(trace):.6g} s: convergence.rule = "required" searches for such'
        )
        return [line] if sooner else []
    fastest = int(np.nanargmin(required))
    ran = problem.run(X[[fastest]], lambda model: model.endless, history=True)
    met = (np.sqrt(ran.variances[0]) <= model.required_sigma).all(axis=1)
    over = int(ran.plan.over[0])
    first = model.step * (over + int(np.argmax(met[over:])))
    if not met[over:].any() or required[fastest] - first < scenario.convergence.window:
        return []
    return [
        f"the fastest plan meets required_sigma after {first:.6g} s, and loses it again until "
        f'{required[fastest]:.6g} s: convergence.rule = "trace" takes plans that meet it when they '
        "end"
    ]


def ways_out(plans: Plans) -> list[str]:
    """Which required 1-sigmas no longer search reaches, as far as the nearest plans tell.

    A line for each that all of them exceed because of an error of which they
    learn nothing, such as a misalignment of the gyro that turns with the whole body: it leaves what
    it is correlated with as badly known as it is itself.
    """
    model, result = plans.problem.model, plans.exactly
    P = result.covariance[np.isfinite(result.trace)]
    lines, units = [], block_units(model.suite)
    for block in range(len(units)):
        own = slice(3 * block, 3 * block + 3)
        bound = model.required_sigma[own][0]
        worst = np.diagonal(P, axis1=1, axis2=2)[:, own].max(axis=1)
        if not len(P) or worst.min() <= bound**2:
            continue
        nearest = P[int(worst.argmin())]
        axis = 3 * block + int(np.diag(nearest)[own].argmax())
        source = _source(nearest, model.initial_covariance, axis)
        if source is not None:
            lines.append(_told(units, block, nearest[axis, axis], *source))
    return lines


def _source(P: Floats, P0: Floats, state: int) -> tuple[int, float, float] | None:
    """The block whose unlearned error is most of a state's variance, None if there is none.

    With the variance that is from it, and the share of its initial 1-sigma that is left, in the
    direction that matters.
    """
    found = None
    for block in range(len(P) // 3):
        of = slice(3 * block, 3 * block + 3)
        along = np.linalg.solve(P[of, of], P[of, state])
        part = float(P[state, of] @ along)
        if part <= _SOURCE * P[state, state]:  # nothing of a block that nothing has been seen of
            continue
        left = float(np.sqrt(part / (along @ P0[of, of] @ along)))
        if left > _NOTHING:
            if block == state // 3:  # itself needs no other source
                return block, part, left
            if found is None or part > found[1]:
                found = block, part, left
    return found


def _told(
    units: list[BlockUnit], block: int, variance: float, source: int, part: float, left: float
) -> str:
    unit, name = units[block], units[source].label
    nothing = f"these plans learn nothing ({left:.0%} of its initial 1-sigma is left)"
    if source == block:
        return (
            f"{name}: of it {nothing}; rather than search longer know it better at the start, or "
            "relax"
        )
    whole, share = (f"{np.sqrt(value) * unit.factor:.3g}" for value in (variance, part))
    return (
        f"{unit.label}: {share} of its {whole} {unit.unit} are an error of {name}, of which "
        f"{nothing}; a longer search makes the rest smaller alone: know {name} better at the "
        "start, or relax"
    )
