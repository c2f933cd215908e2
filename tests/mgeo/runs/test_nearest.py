"""Solutions nearest to feasibility, and the suggestions that follow from them."""

import json

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.problem import Problem

from mgeo import MGEOReal, build_view
from mgeo.evaluation.dominance import find_nondominated
from mgeo.plugins.view import EQUALITY_TOLERANCE
from mgeo.runs.nearest_solutions import MAX_SOLUTIONS
from mgeo.runs.prepare import prepare_run
from mgeo.runs.summary import explain_infeasibility
from mgeo.store.run import Run
from mgeo.store.run_folder import read_run, write_run
from mgeo.validation.entries import FileError
from tests.mgeo.solved import solve

from .test_limits import Told


class Shelf(Problem):
    """Two limits that exclude each other: wide enough and short enough; all rows are kept."""

    def __init__(self, room=1.0):
        self.room, self.rows = room, []
        super().__init__(n_var=2, n_obj=2, n_ieq_constr=2, n_eq_constr=1, xl=0.0, xu=4.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.column_stack([X.sum(axis=1), (X**2).sum(axis=1)])
        out["G"] = np.column_stack([3.0 - X[:, 0], X[:, 0] - self.room])
        out["H"] = X[:, 1:] - 1.0
        violation = np.maximum(np.hstack([out["G"], np.abs(out["H"]) - EQUALITY_TOLERANCE]), 0.0)
        self.rows.append(np.hstack([X, out["F"], violation]))


@pytest.mark.parametrize("algorithm", [NSGA2(pop_size=20), MGEOReal(sigma=0.5, n_walkers=5)])
def test_they_are_ordered_and_the_nearest_of_all_is_the_first(algorithm):
    problem = Shelf()
    found = solve(problem, algorithm, 400, seed=1)
    assert len(found.F) == 0
    assert 1 < len(found.nearest) <= MAX_SOLUTIONS
    rows = np.unique(np.vstack(problem.rows), axis=0)
    total = rows[:, 4:].sum(axis=1)
    nearest = found.nearest
    assert nearest.violation[0].sum() == total.min()
    values = np.hstack([nearest.F, nearest.violation])
    assert len(np.unique(values, axis=0)) == len(values)
    told = np.hstack([nearest.X, nearest.F, nearest.violation])
    for row in told:  # each is one that was evaluated
        assert (rows == row).all(axis=1).sum() == 1
    first = find_nondominated(nearest.violation)
    assert (np.diff(first.astype(int)) <= 0).all()  # those that none beats come first
    assert (np.diff(nearest.violation[first].sum(axis=1)) >= 0.0).all()


def test_nothing_is_kept_once_something_is_feasible():
    problem = Shelf(room=3.5)
    problem.n_eq_constr = 0
    problem._evaluate = lambda X, out, *_, **__: out.update(F=X, G=np.zeros((len(X), 2)))
    found = solve(problem, NSGA2(pop_size=20), 60, seed=1)
    assert len(found.F) > 0
    assert len(found.nearest) == 0


def test_ways_out_name_units_and_round_so_that_they_are_enough():
    nearest = solve(Both(), NSGA2(pop_size=20), 200, seed=2).nearest
    found = explain_infeasibility(build_view(Both(), nearest.X, nearest.F))
    assert len(found.violations) == 1
    assert found.violations[0].startswith("height: ")
    assert found.violations[0].endswith(f"({len(nearest)} of {len(nearest)})")
    (way,) = found.suggestions
    value = float(way.removeprefix("relax height by ").removesuffix(" m"))
    least = nearest.X[0, 0] - 2.0
    assert least <= value < 1.01 * least


class Both(Told):
    """Too high wherever it stands."""

    def __init__(self):
        super().__init__()
        self.xl, self.n_eq_constr = np.array([2.5, 0.0]), 0

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"], out["G"] = X.sum(axis=1), X[:, :1] / 2.0 - 1.0


def run_of(problem, folder):
    prepared = prepare_run("zdt1", parameters={"population": 4}, algorithm="nsga2", evaluations=8)
    outcome = solve(problem, NSGA2(pop_size=20), 100, seed=1)
    run = Run(prepared.configuration, outcome, {"mgeo": "1"})
    write_run(folder, run, overwrite=True)
    return run


def test_it_is_written_and_read_exactly(stand_in, tmp_path):
    run = run_of(Shelf(), tmp_path)
    found = read_run(tmp_path).outcome
    for name in ("X", "F", "violation"):
        written = getattr(run.outcome.nearest, name)
        np.testing.assert_array_equal(getattr(found.nearest, name), written)
    assert found.constraints == ("g1", "g2", "h1")
    data = json.loads((tmp_path / "run.json").read_text())
    data["n_nearest"] = 1
    (tmp_path / "run.json").write_text(json.dumps(data))
    with pytest.raises(FileError, match=r"nearest\.csv: \d+ rows .*: expected 1 rows"):
        read_run(tmp_path)
