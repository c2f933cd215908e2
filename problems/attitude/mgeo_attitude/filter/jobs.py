"""Runs a batch of designs, split into jobs: what designs begin with in common is run once.

The designs of a batch are read as sequences of body rates, one a step. Sorted, designs with a
common beginning are neighbors, and the steps that neighbors have in common define a tree: a job is
an edge of it, from the step at which it leaves another job to the step at which others leave it,
or to convergence. The batch of a generation of MGEO, whose candidates differ from a walker in one
variable, has much in common; random designs have nothing and give one job each.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from mgeo_attitude._compiled import entry
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter.kernel import lanes, load_driver, load_kernel
from mgeo_attitude.filter.layout import layout, transition_pattern
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.variants import constants_of, dynamics_of, initial_values
from mgeo_attitude.maneuvers.schedule import Schedule
from mgeo_attitude.sensors.gyro import is_uneven

#: Deeper than every point of parting.
_LEAF = np.iinfo(np.int64).max
#: Beginnings shorter than this many steps are not worth a copy of the state.
_WORTHWHILE = 16


class Jobs(NamedTuple):
    """n jobs; each comes after the one it leaves.

    Attributes
    ----------
    design : array, shape (n,)
        A design to which all steps of the job belong.
    begin, end : arrays, shape (n,)
        Steps it runs from and to; `end` is -1 for a job that runs to the design's end.
    parent : array, shape (n,)
        Job whose final state it starts from; -1 for the initial state, -1 - k for that of variant k
        of the model.
    snapshot : array, shape (n,)
        Number of the stored state it leaves behind; -1 for none.
    twin : array, shape (n_designs,)
        For each design the equal one that is run.
    """

    design: Ints
    begin: Ints
    end: Ints
    parent: Ints
    snapshot: Ints
    twin: Ints


def separate(variants: Ints) -> Jobs:
    """Every design, flown by these variants of the model, shape (n,), a job of its own."""
    n = len(variants)
    each, none = np.arange(n), np.full(n, -1)
    return Jobs(each, np.zeros(n, dtype=np.int64), none, -1 - variants, none, each)


def shared(rates: Floats, starts: Ints, over: Ints, n_steps: int, variants: Ints) -> Jobs:
    """Jobs in which common beginnings of a variant are run once, and equal designs too.

    Parameters
    ----------
    rates : array, shape (n, m, 3)
    starts, over : arrays, shapes (n, m) and (n,)
        See `maneuvers.schedule.Schedule`.
    n_steps : int
        Length of the longest run.
    variants : array, shape (n,)
        Variant of the model that flies each design.
    """
    if len(rates) == 0:
        return separate(variants)
    ends = np.column_stack([starts[:, 1:], over])
    plans = np.concatenate([rates, ends[:, :, None]], axis=2).reshape(len(rates), -1)
    keys = np.column_stack([variants, plans])
    # the bytes of a row's numbers, the most significant first, which numpy compares at once
    rows = (keys + 0.0).astype(">f8", order="C").view(f"V{8 * keys.shape[1]}")
    order = np.argsort(rows[:, 0], kind="stable")
    ordered = keys[order]
    differs = np.ones(len(order), dtype=bool)
    differs[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    unique = order[differs]
    twin = np.empty(len(order), dtype=np.int64)
    twin[order] = unique[np.cumsum(differs) - 1]
    common = _common_steps(rates[unique], ends[unique])
    # Nobody may end, nor be tested for convergence, before the designs part.
    limit = np.minimum(over[unique], n_steps) - 1
    common = np.minimum(common, np.minimum(limit[1:], limit[:-1]))
    common[common < _WORTHWHILE] = 0
    common[variants[unique[1:]] != variants[unique[:-1]]] = 0
    jobs = _tree(unique, common, twin)
    initial = -1 - variants[jobs.design]
    return jobs._replace(parent=np.where(jobs.parent < 0, initial, jobs.parent))


def _common_steps(rates: Floats, ends: Ints) -> Ints:
    """Steps that each of n sorted designs has in common with the next, shape (n - 1,)."""
    same_rate = (rates[1:] == rates[:-1]).all(axis=2)
    same = same_rate & (ends[1:] == ends[:-1])
    count = np.minimum.accumulate(same, axis=1).sum(axis=1)
    first = np.minimum(count, ends.shape[1] - 1)  # the maneuver in which they part
    row = np.arange(len(first))
    begin = np.where(first > 0, ends[row, first - 1], 0)
    both = np.minimum(ends[1:][row, first], ends[:-1][row, first])
    return np.where(same_rate[row, first], np.maximum(both, begin), begin)


def _tree(unique: Ints, common: Ints, twin: Ints) -> Jobs:
    """Jobs from sorted designs and the steps that neighbors have in common."""
    depth, parent, design = _nodes(unique, common)

    # In the order of their first steps, which puts a job after the one it leaves.
    begin = depth[parent[1:]]
    order = np.argsort(begin, kind="stable")
    place = np.append(np.argsort(order), -1)  # the root, at -1, is no job
    end = depth[1:][order]
    inner = end < _LEAF
    return Jobs(
        design=design[1:][order],
        begin=begin[order],
        end=np.where(inner, end, -1),
        parent=place[parent[1:] - 1][order],
        snapshot=np.where(inner, np.cumsum(inner) - 1, -1),
        twin=twin,
    )


@entry("UniTuple(int64[::1], 3)(int64[::1], int64[::1])")
def _nodes(unique: Ints, common: Ints) -> tuple[Ints, Ints, Ints]:
    """Depths, parents and designs of the nodes of the tree.

    They are the root (0), the designs and the points where designs part. Those on the way from the
    root to the current design are on a stack.
    """
    most = 2 * len(unique) + 1
    depth, parent = np.zeros(most, dtype=np.int64), np.full(most, -1)
    design, stack = np.full(most, -1), np.zeros(most, dtype=np.int64)
    n, top = 1, 0
    for k in range(len(unique)):
        before, last = common[k - 1] if k else 0, 0
        while depth[stack[top]] > before:
            last, top = stack[top], top - 1
        if depth[stack[top]] < before:
            depth[n], parent[n], design[n] = before, stack[top], design[last]
            parent[last] = n
            top += 1
            stack[top] = n
            n += 1
        depth[n], parent[n], design[n] = _LEAF, stack[top], unique[k]
        top += 1
        stack[top] = n
        n += 1
    return depth[:n], parent[:n], design[:n]


class Batch(NamedTuple):
    """Designs, what flies each of them and in how many threads; see `evaluate`."""

    variants: Sequence[FilterModel]
    flown_by: Ints
    plan: Schedule
    threads: int


class Ran(NamedTuple):
    """What the driver leaves of n designs; see `driver.run`."""

    end_step: Ints
    settled: Ints
    trace: Floats
    watched: Floats
    final: Floats
    record: Floats


def run(
    model: FilterModel,
    batch: Batch,
    stops: Ints,
    history: bool = False,
    covariance: bool = False,
    factor: float = 0.0,
) -> Ran:
    """Run the designs until they converge or stop, in whatever threads there are."""
    variants, flown_by, plan, threads = batch
    suite, n, monitors = model.suite, len(stops), model.monitors
    kernel, driver = load_kernel(suite, model.gated, monitors), load_driver()
    at = layout(suite, model.gated, monitors)
    # A history is recorded step by step, so every design is then run by itself from the start.
    jobs = (
        separate(flown_by)
        if history
        else shared(*(plan.asked or (plan.rates, plan.starts)), plan.over, model.n_steps, flown_by)
    )
    n_jobs = len(jobs.design)
    record = np.full((n if history else 0, model.n_steps + 1, suite.n_states), np.nan)
    record[:, 0] = np.array([each.initial_sigma**2 for each in variants])[flown_by[: len(record)]]
    end_step, settled, trace = np.zeros(n, np.int64), np.zeros(n, np.int64), np.empty(n)
    watched, final = np.empty((n, monitors.total)), np.empty((n if covariance else 0, at.attitude))
    # Room for states that jobs leave, as `driver.save` does; the last ones are those at time zero.
    left = np.count_nonzero(jobs.snapshot >= 0)
    states = np.zeros((left + len(variants), at.rotation + model.window_steps + 1))
    states[left:, : at.rotation + 1] = initial_values(model, variants)[::-1]
    matrices, densities = dynamics_of(variants)
    arguments: tuple[Any, ...] = (
        (kernel.step.address, kernel.check.address, lanes()),
        tuple(at),
        (np.zeros(1, dtype=np.int64), np.zeros(n_jobs, dtype=np.int64)),
        jobs[:5],
        states,
        (
            np.ascontiguousarray(plan.rates),
            np.ascontiguousarray(plan.starts),
            plan.over,
            flown_by,
        ),
        (
            matrices,
            densities,
            np.array(transition_pattern(suite)),
            model.step,
            (model.by_polynomials or plan.free is not None) and _alike(densities),
        ),
        model.table,
        constants_of(model, variants),
        (model.window_steps, model.relative_decrease, model.allow_rise, factor),
        (stops, end_step, settled),
        trace,
        (watched, final),
        record,
    )
    others = min(threads, n_jobs) - 1
    with ThreadPoolExecutor(max(others, 1)) as pool:  # it makes no thread before it needs one
        futures = [pool.submit(driver.run, *arguments) for _ in range(others)]
        driver.run(*arguments)
    for future in futures:
        future.result()
    twin = jobs.twin
    final = final[twin] if covariance else final
    return Ran(end_step[twin], settled[twin], trace[twin], watched[twin], final, record)


def _alike(densities: Floats) -> bool:
    """Whether gyros of a bias alone are as noisy about each axis: see `polynomials`."""
    return densities.shape[1] == 6 and not is_uneven(densities)
