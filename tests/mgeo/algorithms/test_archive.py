import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from pymoo.core.population import Population
from pymoo.util.nds.non_dominated_sorting import NonDominatedSorting
from scipy.spatial.distance import cdist

from mgeo import ParetoArchive
from mgeo.algorithms.archive import truncate
from mgeo.evaluation.dominance import (
    find_front_rows,
    find_nondominated,
    find_not_weakly_dominated,
    find_weakly_dominated_rows,
)

from .. import naive

# Few distinct values make ties and duplicates frequent.
SPECIAL = st.sampled_from([0.0, -0.0, 1.0, 2.0, 3.0, np.nan, np.inf, -np.inf])
VALUES = st.one_of(st.integers(0, 4).map(float), st.floats(-1, 1, width=16), SPECIAL)


@st.composite
def batches(draw):
    n_obj = draw(st.integers(1, 4))
    rows = draw(st.integers(0, 40))
    F = draw(hnp.arrays(float, (rows, n_obj), elements=VALUES))
    violations = st.sampled_from([0.0, 0.0, 0.5, 1.0, 2.0, np.nan])
    violation = draw(hnp.arrays(float, rows, elements=violations))
    if draw(st.booleans()):
        violation[:] = np.where(violation == 0, 0.5, violation)  # No point is feasible.
    cuts = sorted(draw(st.lists(st.integers(0, rows), max_size=4)))
    return F, violation, cuts


def labels(n):
    return np.arange(n).astype(object).view(Population)


def build_archive(F, violation=None, cuts=(), max_size=None):
    archive = ParetoArchive(F.shape[1], max_size)
    rows, violation = labels(len(F)), np.zeros(len(F)) if violation is None else violation
    for part in np.split(np.arange(len(F)), cuts):
        archive.add(F[part], rows[part], violation[part])
    return archive


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@given(batches())
def test_archive_agrees_with_plain_loop_for_any_batches(batch):
    F, violation, cuts = batch
    archive = build_archive(F, violation, cuts)
    expected = naive.archive_rows(F.tolist(), violation.tolist())
    assert archive.individuals.tolist() == expected
    assert np.array_equal(archive.F, F[expected])
    failed = ~np.isfinite(F).all(axis=1) | np.isnan(violation)
    assert archive.n_rejected == failed.sum()
    assert archive.violation == (violation[expected[0]] if expected else np.inf)


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@given(batches())
def test_nondominated_points_agree_with_plain_loop(batch):
    F = batch[0]
    assert np.flatnonzero(find_nondominated(F)).tolist() == naive.nondominated_rows(F.tolist())


@pytest.mark.parametrize("n_obj", [1, 2, 3])
def test_weakly_dominated_rows_agree_with_definition(n_obj):
    rng = np.random.default_rng(3)
    for levels in (4, 30):
        for _ in range(40):
            F = rng.integers(0, levels, (40, n_obj)).astype(float)
            front = F[find_nondominated(F)]
            front = front[np.argsort(front[:, 0])]
            new = rng.integers(0, levels, (5, n_obj)).astype(float)
            expected = [i for i, f in enumerate(front) if (new <= f).all(axis=1).any()]
            assert find_weakly_dominated_rows(front, new).tolist() == expected


@pytest.mark.parametrize("n_obj", [2, 3, 5])
@pytest.mark.parametrize("seed", range(3))
def test_archive_of_many_batches_agrees_with_pymoo(n_obj, seed):
    rng = np.random.default_rng(seed)
    F = np.abs(rng.standard_normal((3000, n_obj))).round(3)
    archive = build_archive(F, cuts=range(200, 3000, 200))
    front = NonDominatedSorting().do(F, only_non_dominated_front=True)
    assert np.array_equal(np.unique(archive.F, axis=0), np.unique(F[front], axis=0))
    assert np.array_equal(F[archive.individuals.astype(int)], archive.F)
    assert np.all(np.diff(archive.F[:, 0]) >= 0)


@pytest.mark.parametrize("long", [0, 4096], ids=["sample first", "all at once"])
@pytest.mark.parametrize("n_obj", [1, 2, 3, 4])
def test_not_weakly_dominated_points_agree_with_comparison_of_all_pairs(n_obj, long, monkeypatch):
    monkeypatch.setattr("mgeo.evaluation.dominance._BLOCK_SIZE", 64)
    monkeypatch.setattr("mgeo.evaluation.dominance._MAX_UNSAMPLED_ROWS", long)
    rng = np.random.default_rng(n_obj)
    front = rng.integers(0, 9, (50, n_obj)).astype(float)
    front = front[find_nondominated(front)]
    front = front[np.argsort(front[:, 0], kind="stable")]
    F = rng.integers(0, 9, (70, n_obj)).astype(float)
    expected = [not any((row <= f).all() for row in front) for f in F]
    assert find_not_weakly_dominated(F, front).tolist() == expected


def test_add_returns_entered_points_and_keeps_first_of_equal_points():
    archive = ParetoArchive(2)
    F = np.array([[1.0, 3.0], [1.0, 3.0], [2.0, 4.0], [3.0, 1.0]])
    assert archive.add(F, labels(4)).tolist() == [True, False, False, True]
    assert archive.add(F[:1], np.array([9], dtype=object)).tolist() == [False]
    assert archive.individuals.tolist() == [0, 3]
    assert archive.add(np.array([[0.0, 0.0]]), np.array([5], dtype=object)).tolist() == [True]
    assert archive.individuals.tolist() == [5]


def test_first_feasible_point_replaces_infeasible_points():
    archive = ParetoArchive(2)
    archive.add(np.array([[0.0, 0.0], [5.0, 5.0]]), labels(2), np.array([2.0, 1.0]))
    assert (archive.individuals.tolist(), archive.violation) == ([1], 1.0)
    entered = archive.add(np.array([[9.0, 9.0], [0.0, 0.0]]), labels(2), np.array([0.0, 1.0]))
    assert entered.tolist() == [True, False]
    assert (archive.F.tolist(), archive.violation) == ([[9.0, 9.0]], 0.0)


@pytest.mark.parametrize("n_obj", [2, 3])
@pytest.mark.parametrize("seed", range(3))
def test_truncated_archive_keeps_size_extremes_and_dominance(n_obj, seed):
    rng = np.random.default_rng(seed)
    F = np.abs(rng.standard_normal((2000, n_obj)))
    F /= np.linalg.norm(F, axis=1, keepdims=True)
    limited, same = (build_archive(F, cuts=range(50, 2000, 50), max_size=20) for _ in range(2))
    assert len(limited) == 20
    assert np.array_equal(limited.F, same.F)
    assert np.array_equal(limited.F.min(axis=0), F.min(axis=0))
    assert np.array_equal(limited.F.max(axis=0), F[find_nondominated(F)].max(axis=0))
    assert find_nondominated(limited.F).all()
    assert np.array_equal(F[limited.individuals.astype(int)], limited.F)


def remove_reference(F, size):
    """Return the removed rows in order, with all distances recomputed after each removal."""
    low, span = F.min(axis=0), np.ptp(F, axis=0)
    points = ((F - low) / np.where(span > 0, span, 1.0)).tolist()
    ends = {*F.argmin(axis=0).tolist(), *F.argmax(axis=0).tolist()}
    rows, removed = list(range(len(F))), []
    while len(rows) > size:

        def find_two_nearest(row):
            distances = [math.dist(points[row], points[other]) for other in rows if other != row]
            return sorted(distances)[:2]

        removed.append(min((row for row in rows if row not in ends), key=find_two_nearest))
        rows.remove(removed[-1])
    return removed


def grid_front(n_obj):
    """Return points of a simplex whose distances are exact, so that ties occur."""
    cuts = np.sort(np.random.default_rng(n_obj).integers(0, 129, (150, n_obj - 1)), axis=1)
    F = np.concatenate([np.eye(n_obj), np.diff(cuts / 128, axis=1, prepend=0.0, append=1.0)])
    F = F[find_nondominated(F)]
    return F[np.argsort(F[:, 0], kind="stable")]


@pytest.mark.cases(2)
@pytest.mark.parametrize("n_obj", [2, 3, 4, 7])
def test_truncation_agrees_with_recomputed_distances(n_obj, monkeypatch):
    F = grid_front(n_obj)
    F[:, -1] *= 1024.0  # The scaling by the range must remove this factor.
    assert len(F) > 80
    removed = remove_reference(F, 2 * n_obj)
    for neighbors in (3, 8, 1000):
        monkeypatch.setattr("mgeo.algorithms.archive._N_NEIGHBORS", neighbors)
        for size in (2 * n_obj, len(F) // 2, len(F) - 1):
            selected = np.delete(np.arange(len(F)), removed[: len(F) - size])
            assert np.flatnonzero(truncate(F, size)).tolist() == selected.tolist()
        assert truncate(F, len(F)).all()


def test_truncation_handles_equal_points_and_extreme_extents():
    F = np.array([[0.0, 3.0, 1.0]] + [[1.0, 2.0, 1.0]] * 12 + [[3.0, 0.0, 1.0]])
    selected = truncate(F, 6)
    assert np.count_nonzero(selected) == 6
    assert selected[[0, 12, 13]].all()  # The first of equally crowded rows are removed.
    x = np.sort(np.random.default_rng(0).random(50))
    F = np.column_stack([x, 1 - x])
    assert np.array_equal(truncate(F, 20), truncate(1.7e308 * (2 * F - 1), 20))


def compute_unevenness(F):
    """Return the coefficient of variation of the nearest-neighbor distances; 0 is even."""
    near = cdist(F, F)
    np.fill_diagonal(near, np.inf)
    return near.min(axis=1).std() / near.min(axis=1).mean()


@pytest.mark.parametrize(("n_obj", "most"), [(3, 0.15), (4, 0.12), (6, 0.10)])
def test_truncated_fronts_of_many_objectives_are_evenly_spread(n_obj, most):
    rng = np.random.default_rng(n_obj)
    F = np.abs(rng.standard_normal((2000, n_obj)))
    F /= np.linalg.norm(F, axis=1, keepdims=True)
    drawn = F[rng.choice(len(F), 200, replace=False)]
    truncated = F[truncate(F, 200)]
    assert compute_unevenness(truncated) < most
    assert compute_unevenness(truncated) < 0.4 * compute_unevenness(drawn)
    assert np.array_equal(truncated.min(axis=0), F.min(axis=0))
    assert np.array_equal(truncated.max(axis=0), F.max(axis=0))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [((0,), "n_obj = 0"), ((2, 3), "max_size = 3: expected at least 4")],
)
def test_invalid_archive_parameters_are_rejected(arguments, message):
    with pytest.raises(ValueError, match=message):
        ParetoArchive(*arguments)


@pytest.mark.parametrize("seed", range(20))
def test_front_rows_agree_with_definition_and_are_sorted(seed):
    rng = np.random.default_rng(seed)
    F = rng.integers(0, 8, (rng.integers(1, 40), 2)).astype(float)  # Few values, so many ties.
    F[rng.random(len(F)) < 0.1, rng.integers(2)] = np.nan
    expected = [
        i
        for i, f in enumerate(F)
        if np.isfinite(f).all()
        and not any((g <= f).all() and (g < f).any() for g in F)
        and not any((g == f).all() for g in F[:i])
    ]
    rows = find_front_rows(F)
    assert sorted(rows) == expected
    assert (np.diff(F[rows, 0]) > 0.0).all()
