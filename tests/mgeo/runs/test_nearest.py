"""Solutions nearest to feasibility, and the suggestions derived from them."""

import json
import re

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

from .test_constraint_margins import ColumnWithView


class ContradictoryProblem(Problem):
    """Problem with two contradictory constraints on a length, which stores all evaluations."""

    def __init__(self, upper_bound=1.0):
        self.upper_bound, self.rows = upper_bound, []
        super().__init__(n_var=2, n_obj=2, n_ieq_constr=2, n_eq_constr=1, xl=0.0, xu=4.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.column_stack([X.sum(axis=1), (X**2).sum(axis=1)])
        out["G"] = np.column_stack([3.0 - X[:, 0], X[:, 0] - self.upper_bound])
        out["H"] = X[:, 1:] - 1.0
        violation = np.maximum(np.hstack([out["G"], np.abs(out["H"]) - EQUALITY_TOLERANCE]), 0.0)
        self.rows.append(np.hstack([X, out["F"], violation]))


@pytest.mark.parametrize("algorithm", [NSGA2(pop_size=20), MGEOReal(sigma=0.5, n_walkers=5)])
def test_nearest_solutions_are_sorted_by_violation(algorithm):
    problem = ContradictoryProblem()
    outcome = solve(problem, algorithm, 400, seed=1)
    assert len(outcome.F) == 0
    assert 1 < len(outcome.nearest) <= MAX_SOLUTIONS
    rows = np.unique(np.vstack(problem.rows), axis=0)
    total = rows[:, 4:].sum(axis=1)
    nearest = outcome.nearest
    assert nearest.violation[0].sum() == total.min()
    values = np.hstack([nearest.F, nearest.violation])
    assert len(np.unique(values, axis=0)) == len(values)
    reported = np.hstack([nearest.X, nearest.F, nearest.violation])
    for row in reported:  # Each row is one of the evaluations.
        assert (rows == row).all(axis=1).sum() == 1
    first = find_nondominated(nearest.violation)
    assert (np.diff(first.astype(int)) <= 0).all()  # Nondominated violations come first.
    assert (np.diff(nearest.violation[first].sum(axis=1)) >= 0.0).all()


def test_feasible_run_has_no_nearest_solutions():
    problem = ContradictoryProblem(upper_bound=3.5)
    problem.n_eq_constr = 0
    problem._evaluate = lambda X, out, *_, **__: out.update(F=X, G=np.zeros((len(X), 2)))
    outcome = solve(problem, NSGA2(pop_size=20), 60, seed=1)
    assert len(outcome.F) > 0
    assert len(outcome.nearest) == 0


def test_suggested_relaxation_is_sufficient_and_has_units():
    nearest = solve(TooHighColumn(), NSGA2(pop_size=20), 200, seed=2).nearest
    view = build_view(TooHighColumn(), nearest.X, nearest.F)
    report = explain_infeasibility(view, 10_000)
    required = nearest.X[0, 0] - 2.0
    table = report.build_table()
    assert table["violation"].to_dict() == {"height": required}
    assert table["violated by"].tolist() == [f"{len(nearest)} of {len(nearest)}"]
    (suggestion,) = report.suggestions
    value = float(re.search(r"height by (\S+) m", suggestion)[1])
    assert required <= value < 1.01 * required
    first, *others = explain_infeasibility(view, 200).suggestions
    assert "--evaluations" in first
    assert tuple(others) == report.suggestions


class TooHighColumn(ColumnWithView):
    """Column that is too high for every design."""

    def __init__(self):
        super().__init__()
        self.xl, self.n_eq_constr = np.array([2.5, 0.0]), 0

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"], out["G"] = X.sum(axis=1), X[:, :1] / 2.0 - 1.0


def write_run_of(problem, folder):
    prepared = prepare_run("zdt1", parameters={"population": 4}, algorithm="nsga2", evaluations=8)
    outcome = solve(problem, NSGA2(pop_size=20), 100, seed=1)
    run = Run(prepared.configuration, outcome, {"mgeo": "1"})
    write_run(folder, run, overwrite=True)
    return run


def test_nearest_solutions_are_read_back_exactly(stand_in, tmp_path):
    run = write_run_of(ContradictoryProblem(), tmp_path)
    outcome = read_run(tmp_path).outcome
    for name in ("X", "F", "violation"):
        written = getattr(run.outcome.nearest, name)
        np.testing.assert_array_equal(getattr(outcome.nearest, name), written)
    assert outcome.constraints == ("g1", "g2", "h1")
    data = json.loads((tmp_path / "run.json").read_text())
    data["n_nearest"] = 1
    (tmp_path / "run.json").write_text(json.dumps(data))
    with pytest.raises(FileError, match=r"nearest\.csv: \d+ rows .*: expected 1 rows"):
        read_run(tmp_path)
