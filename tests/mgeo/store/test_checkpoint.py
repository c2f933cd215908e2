"""Runs that are interrupted and resumed from a checkpoint."""

import io
import itertools

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.callback import CallbackCollection
from pymoo.optimize import minimize
from pymoo.problems.multi import BNH, ZDT1, ZDT2

from mgeo import Checkpoint, MGEODirected, MGEOReal, Recorder, read_record, resume
from mgeo.validation.entries import FileError

PROBLEM = ZDT1(n_var=4)


class InterruptedZDT1(ZDT1):
    """Problem that raises KeyboardInterrupt after a number of evaluated batches."""

    def __init__(self, batches, **options):
        super().__init__(**options)
        self.n_left = batches

    def _evaluate(self, X, out, *args, **kwargs):
        if not self.n_left:
            raise KeyboardInterrupt
        self.n_left -= 1
        super()._evaluate(X, out, *args, **kwargs)


# A checkpoint contains the class name, which must be that of the resumed problem.
InterruptedZDT1.__name__ = "ZDT1"


def solve(problem=PROBLEM, algorithm=None, n_gen=12, **options):
    algorithm = algorithm or MGEOReal(0.2, n_walkers=3)
    return minimize(problem, algorithm, ("n_gen", n_gen), **{"seed": 3, **options})


def run_until_interrupt(path, batches, algorithm=None, n_gen=12, **options):
    with pytest.raises(KeyboardInterrupt):
        solve(
            InterruptedZDT1(batches, n_var=4),
            algorithm,
            n_gen,
            **{"callback": Checkpoint(path, every_seconds=0), **options},
        )


def are_equal(a, b):
    return all(np.array_equal(getattr(a, key), getattr(b, key)) for key in ("X", "F", "G", "H"))


@pytest.mark.parametrize("cls", [MGEOReal, MGEODirected])
def test_resumed_run_equals_uninterrupted_run(cls, tmp_path):
    batches = 5
    path = tmp_path / "run.checkpoint"
    run_until_interrupt(path, batches, cls(n_walkers=3))
    resumed = resume(path, PROBLEM)
    assert resumed.n_generations == batches
    result = resumed.run()
    expected = solve(algorithm=cls(n_walkers=3))
    assert are_equal(result, expected)
    assert np.array_equal(result.pop.get("X"), expected.pop.get("X"))
    assert resumed.evaluator.n_eval == expected.algorithm.evaluator.n_eval
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_checkpoints_are_written_at_intervals(tmp_path, monkeypatch):
    path = tmp_path / "run.checkpoint"
    clock = itertools.count()  # Each reading of the clock takes a second.
    monkeypatch.setattr("mgeo.store.checkpoint.time.monotonic", lambda: float(next(clock)))
    written = []
    monkeypatch.setattr(
        "mgeo.store.checkpoint.write_file", lambda path, content: written.append(len(content))
    )
    solve(n_gen=20, callback=Checkpoint(path, every_seconds=6))
    assert 3 <= len(written) <= 5
    written.clear()
    solve(n_gen=20, callback=Checkpoint(path, every_seconds=1e9))
    assert len(written) == 2  # The first and the last generation are always saved.


@pytest.fixture(scope="module")
def checkpoint(tmp_path_factory):
    path = tmp_path_factory.mktemp("kept") / "run.checkpoint"
    solve(n_gen=4, callback=Checkpoint(path))
    return path


def test_damaged_file_is_rejected(checkpoint, tmp_path):
    content, path = checkpoint.read_bytes(), tmp_path / "bad"
    pickled = io.BytesIO()
    np.savez(pickled, json=np.array([print], dtype=object))
    flipped = bytearray(content)
    flipped[len(content) // 2] ^= 0x41
    for damaged in (
        b"",
        content[:100],
        content[:-1],
        bytes(flipped),
        b"text\n",
        pickled.getvalue(),
    ):
        path.write_bytes(damaged)
        with pytest.raises(FileError, match="bad: not a checkpoint"):
            resume(path, PROBLEM)


def test_checkpoint_of_another_version_is_rejected(checkpoint, monkeypatch):
    monkeypatch.setattr("mgeo.store.provenance.version", lambda name: "9.9")
    with pytest.raises(ValueError, match=r"another version: mgeo = '9.9', expected '\d"):
        resume(checkpoint, PROBLEM)
    assert resume(checkpoint, PROBLEM, check=False).n_generations == 4


class ProblemWithOptions(ZDT1):
    def __init__(self, **loads):
        super().__init__(n_var=4)
        self.loads = loads

    def to_options(self):
        return {"loads": self.loads}


def test_checkpoint_of_another_problem_reports_first_difference(checkpoint, tmp_path):
    for problem, message in (
        (ZDT2(n_var=4), r"class = 'ZDT2', expected 'ZDT1'"),
        (ZDT1(n_var=5), r"n_var = 5, expected 4"),
        (BNH(), r"class = 'BNH', expected 'ZDT1'"),
    ):
        with pytest.raises(ValueError, match=f"belongs to another problem: {message}"):
            resume(checkpoint, problem)
    path = tmp_path / "run.checkpoint"
    solve(ProblemWithOptions(wind=1.5, snow=2), n_gen=1, callback=Checkpoint(path))
    with pytest.raises(ValueError, match=r"options.loads.wind = None, expected 1.5"):
        resume(path, ProblemWithOptions(snow=2))
    assert resume(path, ProblemWithOptions(wind=1.5, snow=2)).n_generations == 1


def test_invalid_arguments_are_rejected(tmp_path):
    with pytest.raises(FileNotFoundError, match="is not a folder: create it"):
        Checkpoint(tmp_path / "none" / "run.checkpoint")
    with pytest.raises(FileNotFoundError):
        resume(tmp_path / "none", PROBLEM)
    with pytest.raises(TypeError, match="NSGA2: expected an algorithm of the MGEO"):
        solve(algorithm=NSGA2(8), callback=Checkpoint(tmp_path / "a"))


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("batches", [1, 6])
def test_record_is_complete_after_resuming(order, batches, tmp_path):
    path, folder = tmp_path / "run.checkpoint", tmp_path / "record"

    def callbacks():
        # Only the first generation is saved in a checkpoint, so the record is ahead of it.
        checkpoint_callback = Checkpoint(path, every_seconds=1e9)
        recorder = Recorder(folder, every_seconds=0)
        return CallbackCollection(*(checkpoint_callback, recorder)[::order])

    run_until_interrupt(path, batches, callback=callbacks())
    assert len(read_record(folder)) == 12 * batches
    resumed = resume(path, PROBLEM, callback=callbacks())
    assert resumed.n_generations < batches or batches == 1
    resumed.run()
    table = read_record(folder)
    evaluated = []
    solve(callback=lambda a: evaluated.append(a.pop.get("X", "F")))
    assert table["generation"].tolist() == np.repeat(np.arange(1, 13), 12).tolist()
    assert np.array_equal(table.iloc[:, 1:5], np.concatenate([X for X, _ in evaluated]))
    assert np.array_equal(table[["f1", "f2"]], np.concatenate([F for _, F in evaluated]))
