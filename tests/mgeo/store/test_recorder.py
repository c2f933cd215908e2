"""Records of every evaluation of a run."""

import numpy as np
import pytest
from pymoo.algorithms.moo.gde3 import GDE3
from pymoo.algorithms.moo.moead import MOEAD
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.evaluator import Evaluator
from pymoo.optimize import minimize
from pymoo.problems.multi import BNH, OSY, ZDT1, ZDT2

from mgeo import MGEOReal, Recorder, TolerantEvaluator, read_record

PROBLEM = ZDT1(n_var=3)


def solve(problem=PROBLEM, algorithm=None, n_gen=10, **options):
    algorithm = algorithm or MGEOReal(0.2, n_walkers=4)
    return minimize(problem, algorithm, ("n_gen", n_gen), **{"seed": 1, **options})


class LoggingEvaluator(Evaluator):
    def __init__(self):
        self.batches = []
        super().__init__(
            callback=lambda population: self.batches.append(population.get("X", "F", "G"))
        )


@pytest.mark.parametrize(
    ("algorithm", "problem", "every_seconds"),
    [
        (MGEOReal(0.2, n_walkers=4), PROBLEM, 0.0),
        (NSGA2(12), BNH(), 1e9),
        (GDE3(12), OSY(), 0.01),
    ],
    ids=["mgeo", "nsga2", "gde3"],
)
def test_record_contains_every_evaluation_in_order(algorithm, problem, every_seconds, tmp_path):
    evaluator = LoggingEvaluator()
    recorder = Recorder(tmp_path, every_seconds=every_seconds)
    solve(problem, algorithm, callback=recorder, evaluator=evaluator)
    table = read_record(tmp_path)
    X, F, G = (np.concatenate(parts) for parts in zip(*evaluator.batches, strict=True))
    names = [f"x{i + 1}" for i in range(problem.n_var)], [f"g{i + 1}" for i in range(G.shape[1])]
    assert list(table) == ["generation", *names[0], "f1", "f2", *names[1], "failed"]
    assert np.array_equal(table[names[0]], X)
    assert np.array_equal(table[["f1", "f2"]], F)
    assert np.array_equal(table[names[1]], G)
    generations = np.repeat(np.arange(1, 11), [len(part[0]) for part in evaluator.batches])
    assert np.array_equal(table["generation"], generations)
    assert not table["failed"].any()


def test_failed_evaluations_are_marked(tmp_path):
    class Failing(ZDT1):
        def _evaluate(self, X, out, *args, **kwargs):
            super()._evaluate(X, out, *args, **kwargs)
            out["F"][X[:, 0] > 0.7, 1] = np.inf

    for algorithm in (MGEOReal(0.2, n_walkers=4), NSGA2(12)):
        recorder = Recorder(tmp_path, overwrite=True)
        solve(Failing(n_var=3), algorithm, callback=recorder, evaluator=TolerantEvaluator())
        table = read_record(tmp_path)
        assert 0 < table["failed"].sum() < len(table)
        assert (table["failed"] == (table["x1"] > 0.7)).all()
        assert (table["failed"] == table["f1"].isna()).all()


def test_record_is_overwritten_only_on_request(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    solve(callback=Recorder(tmp_path))
    before = read_record(tmp_path)
    with pytest.raises(ValueError, match="holds a record"):
        solve(callback=Recorder(tmp_path), seed=2)
    assert read_record(tmp_path).equals(before)
    solve(callback=Recorder(tmp_path, overwrite=True), seed=2)
    assert len(read_record(tmp_path)) == 120
    assert not read_record(tmp_path).equals(before)
    assert (tmp_path / "notes.txt").exists()


def test_resumed_run_requires_its_own_record(tmp_path):
    def run_generations(problem, n_iter=4):
        run = MGEOReal(n_walkers=4).setup(problem, seed=1)
        for _ in range(n_iter):
            run.next()
        run.n_iter = n_iter
        return run

    with pytest.raises(ValueError, match="ends with generation 0: expected the record"):
        Recorder(tmp_path).record(run_generations(PROBLEM))
    solve(n_gen=2, callback=Recorder(tmp_path))
    with pytest.raises(ValueError, match=r"columns .*: expected"):
        Recorder(tmp_path).record(run_generations(ZDT2(n_var=4), 3))
    with pytest.raises(ValueError, match="ends with generation 2: expected the record of the gen"):
        Recorder(tmp_path).record(run_generations(PROBLEM))
    assert len(read_record(tmp_path)) == 24


def test_unsupported_algorithm_is_rejected(tmp_path):
    directions = np.column_stack([np.linspace(0, 1, 10), np.linspace(1, 0, 10)])
    decomposition = MOEAD(directions, n_neighbors=3)
    with pytest.raises(ValueError, match=r"MOEAD made \d+ evaluations in generation 2 and has"):
        solve(algorithm=decomposition, callback=Recorder(tmp_path))


def test_damaged_record_is_rejected(tmp_path):
    with pytest.raises(FileNotFoundError, match="holds no record"):
        read_record(tmp_path)
    solve(callback=Recorder(tmp_path, every_seconds=0))
    path = tmp_path / "000000002.npz"
    content = path.read_bytes()
    middle = len(content) // 2
    for damaged in (
        b"",
        content[:-1],
        content[:middle],
        content[:middle] + b"x" + content[middle:],
    ):
        path.write_bytes(damaged)
        with pytest.raises(ValueError, match=r"000000002\.npz: not an archive"):
            read_record(tmp_path)
