"""Splits a batch of designs into jobs, so that what designs begin with in common is run once.

The designs of a batch are read as sequences of body rates, one a step. Sorted, designs with a
common beginning are neighbors, and the steps that neighbors have in common define a tree: a job is
an edge of it, from the step at which it leaves another job to the step at which others leave it,
or to convergence. The batch of a generation of MGEO, whose candidates differ from a walker in one
variable, has much in common; random designs have nothing and give one job each.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from mgeo_attitude._typing import Floats, Ints

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


@njit(cache=True)
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
