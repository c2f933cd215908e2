"""Job scheduling for a batch of designs: a common initial part of several designs runs only once.

A design is a sequence of body rates, one per filter step. After sorting, designs with a common
initial part are neighbors, and the lengths of the common parts define a tree. A job is an edge of
the tree. The job starts where it branches off its parent job, and ends where other jobs branch off
or at the end of the run. In one generation of MGEO each candidate differs from its walker in one
variable, so that many steps are shared. Random designs share no steps, with one job per design.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from mgeo_attitude._compiled import compile_on_first_call
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter.kernel import count_lanes, load_driver, load_kernel
from mgeo_attitude.filter.layout import build_layout, compute_transition_pattern
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.variants import compute_initial_values, stack_constants, stack_dynamics
from mgeo_attitude.maneuvers.schedule import Schedule
from mgeo_attitude.sensors.gyro import has_axis_dependent_noise

#: Depth of a leaf, larger than the depth of any branching point.
_LEAF_DEPTH = np.iinfo(np.int64).max
#: Least number of common steps for which storing the filter state saves time.
_MIN_COMMON_STEPS = 16


class Jobs(NamedTuple):
    """Table of n filter jobs. Each job runs the covariance filter over a range of steps of one
    design.

    The table has one array per column. A job starts from the final state of its parent job.

    Attributes
    ----------
    design : array, shape (n,)
        Index of a design that contains all steps of the job.
    begin, end : arrays, shape (n,)
        First and last step; `end` is -1 if the job runs to the end of the design.
    parent : array, shape (n,)
        Index of the job whose final state is the initial state of this job; -1 - k for the initial
        state of variant k of the model.
    snapshot : array, shape (n,)
        Index of the stored final state; -1 if no other job starts from the final state.
    representative : array, shape (n_designs,)
        Index of the equal design that is run in place of each design.
    """

    design: Ints
    begin: Ints
    end: Ints
    parent: Ints
    snapshot: Ints
    representative: Ints


def build_separate_jobs(variant_index: Ints) -> Jobs:
    """Build a job table with one complete filter run per design, without steps shared by designs.

    Parameters
    ----------
    variant_index : array, shape (n,)
        Model variant of each design.
    """
    n = len(variant_index)
    indices, none = np.arange(n), np.full(n, -1)
    return Jobs(indices, np.zeros(n, dtype=np.int64), none, -1 - variant_index, none, indices)


def build_shared_jobs(
    rates: Floats, starts: Ints, maneuver_end_steps: Ints, n_steps: int, variant_index: Ints
) -> Jobs:
    """Build a job table in which initial filter steps common to several designs are run only once.

    Equal designs are also run only once. Designs of different model variants share no steps.

    Parameters
    ----------
    rates : array, shape (n, m, 3)
        Body rates [rad/s].
    starts, maneuver_end_steps : arrays, shapes (n, m) and (n,)
        See `maneuvers.schedule.Schedule`.
    n_steps : int
        Length of the longest run.
    variant_index : array, shape (n,)
        Model variant of each design.
    """
    if len(rates) == 0:
        return build_separate_jobs(variant_index)
    ends = np.column_stack([starts[:, 1:], maneuver_end_steps])
    plans = np.concatenate([rates, ends[:, :, None]], axis=2).reshape(len(rates), -1)
    keys = np.column_stack([variant_index, plans])
    # Big-endian bytes let numpy compare whole rows in one operation.
    rows = (keys + 0.0).astype(">f8", order="C").view(f"V{8 * keys.shape[1]}")
    order = np.argsort(rows[:, 0], kind="stable")
    ordered = keys[order]
    is_new = np.ones(len(order), dtype=bool)
    is_new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    unique = order[is_new]
    representative = np.empty(len(order), dtype=np.int64)
    representative[order] = unique[np.cumsum(is_new) - 1]
    common = _count_common_steps(rates[unique], ends[unique])
    # A design must branch off before it ends or is tested for convergence.
    last_common_steps = np.minimum(maneuver_end_steps[unique], n_steps) - 1
    common = np.minimum(common, np.minimum(last_common_steps[1:], last_common_steps[:-1]))
    common[common < _MIN_COMMON_STEPS] = 0
    common[variant_index[unique[1:]] != variant_index[unique[:-1]]] = 0
    jobs = _build_tree(unique, common, representative)
    initial = -1 - variant_index[jobs.design]
    return jobs._replace(parent=np.where(jobs.parent < 0, initial, jobs.parent))


def _count_common_steps(rates: Floats, ends: Ints) -> Ints:
    """Count the initial steps in which each design has the same body rates as the next design in
    sorted order.
    """
    same_rate = (rates[1:] == rates[:-1]).all(axis=2)
    same = same_rate & (ends[1:] == ends[:-1])
    count = np.minimum.accumulate(same, axis=1).sum(axis=1)
    first = np.minimum(count, ends.shape[1] - 1)  # Index of the first maneuver that differs.
    row = np.arange(len(first))
    begin = np.where(first > 0, ends[row, first - 1], 0)
    both = np.minimum(ends[1:][row, first], ends[:-1][row, first])
    return np.where(same_rate[row, first], np.maximum(both, begin), begin)


def _build_tree(unique: Ints, common: Ints, representative: Ints) -> Jobs:
    depth, parent, design = _build_nodes(unique, common)

    # Jobs are sorted by their first steps, so that a parent precedes its children.
    begin = depth[parent[1:]]
    order = np.argsort(begin, kind="stable")
    place = np.append(np.argsort(order), -1)  # The root, at index -1, is not a job.
    end = depth[1:][order]
    inner = end < _LEAF_DEPTH
    return Jobs(
        design=design[1:][order],
        begin=begin[order],
        end=np.where(inner, end, -1),
        parent=place[parent[1:] - 1][order],
        snapshot=np.where(inner, np.cumsum(inner) - 1, -1),
        representative=representative,
    )


@compile_on_first_call("UniTuple(int64[::1], 3)(int64[::1], int64[::1])")
def _build_nodes(unique: Ints, common: Ints) -> tuple[Ints, Ints, Ints]:
    """Build the prefix tree of sorted designs. Designs that begin with the same maneuvers share a
    path up to the step at which they differ.

    Return three arrays with one entry per node: the step at which the node branches off, the index
    of its parent node, and the index of a design that passes through the node. The nodes are the
    root (node 0), the designs, and the branching points. A stack contains the path from the root to
    the current design.
    """
    max_nodes = 2 * len(unique) + 1
    depth, parent = np.zeros(max_nodes, dtype=np.int64), np.full(max_nodes, -1)
    design, stack = np.full(max_nodes, -1), np.zeros(max_nodes, dtype=np.int64)
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
        depth[n], parent[n], design[n] = _LEAF_DEPTH, stack[top], unique[k]
        top += 1
        stack[top] = n
        n += 1
    return depth[:n], parent[:n], design[:n]


class Batch(NamedTuple):
    """Batch of designs to be evaluated, each with a variant of the filter model."""

    variants: Sequence[FilterModel]
    variant_index: Ints
    plan: Schedule
    threads: int


class BatchResult(NamedTuple):
    """Results of the compiled filter for a batch of designs.

    `driver.run` documents the shapes of the arrays.
    """

    end_step: Ints
    settling_step: Ints
    trace: Floats
    monitors: Floats
    covariance: Floats
    variances: Floats


def run_batch(
    model: FilterModel,
    batch: Batch,
    last_steps: Ints,
    history: bool = False,
    covariance: bool = False,
    settling_factor: float = 0.0,
) -> BatchResult:
    """Run the compiled filter for each design until it converges or reaches its last step.

    Parameters
    ----------
    model : FilterModel
    batch : Batch
    last_steps : array of int, shape (n,)
        Last allowed step of each design.
    history : bool
        Whether to record the variances at every step.
    covariance : bool
        Whether to return the covariances at the end.
    settling_factor : float
        Factor on the final trace below which the trace is settled; 0 to skip the settling step.
    """
    variants, variant_index, plan, threads = batch
    suite, n, monitors = model.suite, len(last_steps), model.monitors
    kernel, driver = load_kernel(suite, model.gated, monitors), load_driver()
    layout = build_layout(suite, model.gated, monitors)
    # A history is recorded only if every design runs separately from the start.
    jobs = (
        build_separate_jobs(variant_index)
        if history
        else build_shared_jobs(
            *(plan.commands or (plan.rates, plan.starts)),
            plan.maneuver_end_steps,
            model.n_steps,
            variant_index,
        )
    )
    n_jobs = len(jobs.design)
    record = np.full((n if history else 0, model.n_steps + 1, suite.n_states), np.nan)
    record[:, 0] = np.array([each.initial_sigma**2 for each in variants])[
        variant_index[: len(record)]
    ]
    end_step, settling_step, trace = np.zeros(n, np.int64), np.zeros(n, np.int64), np.empty(n)
    monitor_values, covariances = (
        np.empty((n, monitors.n_values)),
        np.empty((n if covariance else 0, layout.attitude)),
    )
    # The states that `driver.save_lane` stores come first, the initial states of the variants last.
    n_stored = np.count_nonzero(jobs.snapshot >= 0)
    states = np.zeros((n_stored + len(variants), layout.rotation + model.window_steps + 1))
    states[n_stored:, : layout.rotation + 1] = compute_initial_values(model, variants)[::-1]
    matrices, densities = stack_dynamics(variants)
    arguments: tuple[Any, ...] = (
        (kernel.step.address, kernel.check.address, count_lanes()),
        tuple(layout),
        (np.zeros(1, dtype=np.int64), np.zeros(n_jobs, dtype=np.int64)),
        jobs[:5],
        states,
        (
            np.ascontiguousarray(plan.rates),
            np.ascontiguousarray(plan.starts),
            plan.maneuver_end_steps,
            variant_index,
        ),
        (
            matrices,
            densities,
            np.array(compute_transition_pattern(suite)),
            model.step,
            (model.use_polynomials or plan.free is not None) and _is_isotropic(densities),
        ),
        model.orbit_table,
        stack_constants(model, variants),
        (model.window_steps, model.relative_decrease, model.allow_rise, settling_factor),
        (last_steps, end_step, settling_step),
        trace,
        (monitor_values, covariances),
        record,
    )
    n_helpers = min(threads, n_jobs) - 1
    with ThreadPoolExecutor(max(n_helpers, 1)) as pool:  # Threads start only when they are needed.
        futures = [pool.submit(driver.run, *arguments) for _ in range(n_helpers)]
        driver.run(*arguments)
    for future in futures:
        future.result()
    representative = jobs.representative
    covariances = covariances[representative] if covariance else covariances
    return BatchResult(
        end_step[representative],
        settling_step[representative],
        trace[representative],
        monitor_values[representative],
        covariances,
        record,
    )


def _is_isotropic(densities: Floats) -> bool:
    """Return True if the gyro noise is isotropic and the bias is the only gyro error state."""
    return densities.shape[1] == 6 and not has_axis_dependent_noise(densities)
