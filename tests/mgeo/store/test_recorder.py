"""A record holds every evaluation, can be read at any time, and takes little memory."""

import os
import sqlite3
import threading
import time
from contextlib import closing
from pkgutil import resolve_name

import numpy as np
import pytest
from pymoo.algorithms.moo.gde3 import GDE3
from pymoo.algorithms.moo.moead import MOEAD
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.evaluator import Evaluator
from pymoo.core.mixed import MixedVariableGA
from pymoo.core.problem import Problem
from pymoo.core.variable import Choice, Integer, Real
from pymoo.optimize import minimize
from pymoo.problems.multi import BNH, OSY, ZDT1, ZDT2

from mgeo import (
    MGEOCanonical,
    MGEOReal,
    Recorder,
    TolerantEvaluator,
    read_record,
)
from mgeo.store import record_file
from mgeo.validation.tables import FileError

PROBLEM = ZDT1(n_var=3)


def solve(problem=PROBLEM, algorithm=None, n_gen=10, **options):
    algorithm = algorithm or MGEOReal(0.2, n_walkers=4)
    return minimize(problem, algorithm, ("n_gen", n_gen), **{"seed": 1, **options})


class Spy(Evaluator):
    def __init__(self):
        self.seen = []
        super().__init__(
            callback=lambda population: self.seen.append(population.get("X", "F", "G"))
        )


@pytest.mark.cases(2)
@pytest.mark.parametrize(
    "algorithm", [MGEOReal(0.2, n_walkers=4), NSGA2(12), GDE3(12)], ids=["mgeo", "nsga2", "gde3"]
)
@pytest.mark.parametrize("problem", [PROBLEM, BNH(), OSY()], ids=["zdt1", "bnh", "osy"])
@pytest.mark.parametrize("chunk_rows", [1, 50, 10_000])
def test_every_evaluation_is_there_in_order(algorithm, problem, chunk_rows, tmp_path):
    spy = Spy()
    recorder = Recorder(tmp_path, every_seconds=0.0, chunk_rows=chunk_rows)
    solve(problem, algorithm, callback=recorder, evaluator=spy)
    table = read_record(tmp_path)
    X, F, G = (np.concatenate(parts) for parts in zip(*spy.seen, strict=True))
    names = [f"x{i + 1}" for i in range(problem.n_var)], [f"g{i + 1}" for i in range(G.shape[1])]
    assert list(table) == ["generation", *names[0], "f1", "f2", *names[1], "failed"]
    assert np.array_equal(table[names[0]], X)
    assert np.array_equal(table[["f1", "f2"]], F)
    assert np.array_equal(table[names[1]], G)
    generations = np.repeat(np.arange(1, 11), [len(part[0]) for part in spy.seen])
    assert np.array_equal(table["generation"], generations)
    assert not table["failed"].any()


def test_rows_are_written_when_they_are_many_or_the_time_has_come(tmp_path, monkeypatch):
    now = [0.0]
    monkeypatch.setattr("mgeo.store.recorder.time.monotonic", lambda: now[0])
    lengths = []

    def watch(algorithm):
        now[0] += 1.0
        recorder(algorithm)
        lengths.append(len(read_record(tmp_path)))

    recorder = Recorder(tmp_path, every_seconds=4.0, chunk_rows=60)
    solve(n_gen=11, callback=watch)  # 12 rows a generation
    assert lengths == [12, 12, 12, 12, 60, 60, 60, 60, 108, 108, 132]
    lengths.clear()
    recorder = Recorder(tmp_path, every_seconds=99.0, chunk_rows=36, overwrite=True)
    solve(n_gen=9, callback=watch)
    assert lengths == [12, 12, 12, 48, 48, 48, 84, 84, 108]
    assert [path.name for path in tmp_path.iterdir()] == ["record.sqlite"]


def test_memory_is_bounded_by_the_rows_of_a_write_and_a_generation(tmp_path):
    recorder = Recorder(tmp_path, every_seconds=1e9, chunk_rows=100)
    held = []

    def watch(algorithm):
        recorder(algorithm)
        held.append(sum(len(rows) for _, rows in recorder._buffer))

    solve(n_gen=60, callback=watch)
    assert max(held) < 100 + 12


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


def test_columns_may_be_chosen(tmp_path):
    class Named(ZDT1):
        var_names = ("width [m]", "a/b", "../c")
        obj_names = ("mass [kg]", "cost")

    solve(Named(n_var=3), callback=Recorder(tmp_path))
    table = read_record(tmp_path, ["mass [kg]", "../c"])
    assert list(table) == ["mass [kg]", "../c"]
    assert table.equals(read_record(tmp_path)[["mass [kg]", "../c"]])
    with pytest.raises(
        ValueError, match=r"has no column 'mass': expected one of generation, width \[m\]"
    ):
        read_record(tmp_path, ["mass"])


@pytest.mark.slow
def test_it_can_be_read_while_it_grows(tmp_path):
    problems, lengths, done = [], [], threading.Event()

    def read():
        while not done.is_set():
            try:
                table = read_record(tmp_path)
            except FileNotFoundError:
                continue  # before the first generation
            except Exception as error:
                problems.append(error)
                done.set()
                return
            if not table["generation"].is_monotonic_increasing:
                problems.append("not in order")
            lengths.append(len(table))

    recorder = Recorder(tmp_path, every_seconds=0.0, chunk_rows=50)

    def record(algorithm):
        recorder(algorithm)
        if algorithm.n_gen % 5 == 0:  # now and then let the reader see this state too
            before = len(lengths)
            while len(lengths) < before + 2 and not done.is_set():
                time.sleep(0.001)

    reader = threading.Thread(target=read)
    reader.start()
    try:
        solve(n_gen=60, callback=record)
    finally:
        done.set()
        reader.join()
    assert not problems
    assert lengths == sorted(lengths)
    assert {60 * i for i in range(1, 13)} <= set(lengths)
    assert all(length % 12 == 0 for length in lengths)


def test_a_record_is_read_though_every_reading_meets_a_writer(tmp_path, monkeypatch):
    solve(callback=Recorder(tmp_path))
    _, generations = record_file.read(tmp_path)
    whole, left = resolve_name("mgeo.store.record_file._read"), iter(range(11, 31))

    def met(folder):
        for number in left:
            record_file.append(folder, [(number, generations[0])])
            raise FileError("database disk image is malformed")
        return whole(folder)

    monkeypatch.setattr(record_file, "_read", met)
    assert len(record_file.read(tmp_path)[1]) == 30


def test_a_record_is_not_overwritten_unless_told(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    solve(callback=Recorder(tmp_path))
    before = read_record(tmp_path)
    with pytest.raises(ValueError, match="holds a record of 120 evaluations"):
        solve(callback=Recorder(tmp_path), seed=2)
    assert read_record(tmp_path).equals(before)
    solve(callback=Recorder(tmp_path, overwrite=True, chunk_rows=50), seed=2)
    assert len(read_record(tmp_path)) == 120
    assert not read_record(tmp_path).equals(before)
    assert (tmp_path / "notes.txt").exists()
    recorder = Recorder(tmp_path / "new")
    solve(callback=recorder)
    with pytest.raises(ValueError, match="holds a record"):  # the same object, another run
        solve(callback=recorder)


def test_a_new_record_removes_what_a_process_killed_at_its_beginning_left(tmp_path):
    left, other = tmp_path / ".record.sqlite.0123456789abcdef.tmp", tmp_path / ".mine.tmp"
    for path in (left, other):
        path.touch()
    minimize(ZDT1(), NSGA2(10), ("n_gen", 2), callback=Recorder(tmp_path), seed=1)
    assert {path.name for path in tmp_path.iterdir()} == {"record.sqlite", other.name}


def test_a_resumed_run_needs_its_own_record(tmp_path):
    def begun(problem, n_iter=4):
        run = MGEOReal(n_walkers=4).setup(problem, seed=1)
        for _ in range(n_iter):
            run.next()
        run.n_iter = n_iter
        return run

    with pytest.raises(ValueError, match="holds no record: expected that of the generations bef"):
        Recorder(tmp_path).take(begun(PROBLEM))
    solve(n_gen=2, callback=Recorder(tmp_path))
    with pytest.raises(ValueError, match="ends with generation 2: expected the generations befo"):
        Recorder(tmp_path).take(begun(PROBLEM))
    with pytest.raises(ValueError, match="the record of another problem"):
        Recorder(tmp_path).take(begun(ZDT2(n_var=4), 3))
    assert len(read_record(tmp_path)) == 24


class Mixed(Problem):
    def __init__(self, **more):
        variables = {"width": Real(bounds=(0, 1)), "teeth": Integer(bounds=(0, 9)), **more}
        super().__init__(vars=variables, n_obj=1)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.array([x["width"] + x["teeth"] for x in X])


@pytest.mark.parametrize("algorithm", [MixedVariableGA(12), MGEOCanonical(n_walkers=2, bits=3)])
def test_variables_of_several_types_are_columns_of_numbers(algorithm, tmp_path):
    result = solve(Mixed(), algorithm, callback=Recorder(tmp_path))
    table = read_record(tmp_path)
    assert list(table) == ["generation", "width", "teeth", "f1", "failed"]
    assert len(table) == result.algorithm.evaluator.n_eval
    assert (table["f1"] == table["width"] + table["teeth"]).all()


def test_a_choice_is_recorded_as_the_number_of_its_option(tmp_path):
    problem = Mixed(material=Choice(options=["steel", "wood"]))
    result = solve(problem, MixedVariableGA(8), callback=Recorder(tmp_path))
    table = read_record(tmp_path)
    assert set(table["material"]) == {0.0, 1.0}
    best = table.loc[table["f1"].idxmin()]
    assert problem.vars["material"].options[int(best["material"])] == result.X["material"]


def test_what_cannot_be_recorded_is_refused(tmp_path):
    directions = np.column_stack([np.linspace(0, 1, 10), np.linspace(1, 0, 10)])
    decomposition = MOEAD(directions, n_neighbors=3)
    with pytest.raises(ValueError, match=r"MOEAD made \d+ evaluations in generation 2 and hands"):
        solve(algorithm=decomposition, callback=Recorder(tmp_path))

    (tmp_path / "file").write_text("")
    with pytest.raises(NotADirectoryError, match="is a file: expected a folder"):
        Recorder(tmp_path / "file")
    with pytest.raises(ValueError, match="chunk_rows = 0"):
        Recorder(tmp_path, chunk_rows=0)


def test_damage_is_noticed(tmp_path):
    with pytest.raises(FileNotFoundError, match="holds no record"):
        read_record(tmp_path)
    solve(callback=Recorder(tmp_path, chunk_rows=50))
    path = tmp_path / "record.sqlite"
    content, table = path.read_bytes(), read_record(tmp_path)
    for bad in (content[:-1], content[:5000], b"x" * 5000, content[:4096] + bytes(len(content))):
        path.write_bytes(bad)
        with pytest.raises(ValueError, match=r"record\.sqlite"):
            read_record(tmp_path)
    told = []
    for place in range(0, len(content), 197):
        spoiled = bytes([content[place] ^ 0x20])
        path.write_bytes(content[:place] + spoiled + content[place + 1 :])
        try:
            found = read_record(tmp_path)
        except (ValueError, OSError) as error:
            told.append(str(error))
        else:
            assert found.equals(table)  # a byte that nothing hangs on
    assert all("record.sqlite" in text or "holds no record" in text for text in told)
    assert len(told) > table[["x1", "x2", "x3", "f1", "f2"]].size * 8 / 197
    path.unlink()
    (tmp_path / "index.json").write_text("{}")
    with pytest.raises(ValueError, match=r"of an earlier mgeo: expected record\.sqlite"):
        read_record(tmp_path)


SPOILED = {
    "PRAGMA user_version=7": "format = 7: this version of mgeo reads format 3",
    "CREATE TABLE more (x)": "it has other tables",
    "CREATE TRIGGER t AFTER INSERT ON names BEGIN DELETE FROM generations; END": "other tables",
    "DELETE FROM names": "it has no names",
    "UPDATE names SET X = '[1]'": r"X\[0\] = 1: expected a string",
    "UPDATE names SET X = '['": "Expecting",
    'UPDATE names SET F = \'["f1", "f3"]\'': "generation 1 is not what was written",
    'UPDATE names SET F = \'["f1", "x1"]\'': "expected different names",
    "DELETE FROM generations WHERE number = 3": "generation 3 is not what was written",
    "UPDATE generations SET number = number + 1000": "generation 1 is not",
    "UPDATE generations SET candidates = zeroblob(8) WHERE number = 2": "generation 2 is not",
    "UPDATE generations SET candidates = zeroblob(900000) WHERE number = 2": "damaged",
    "UPDATE generations SET candidates = 3 WHERE number = 2": "record.sqlite",
    "UPDATE generations SET dtype = 'O'": "generation 1 is not",
}


@pytest.mark.parametrize("statement", SPOILED)
def test_what_is_in_a_record_is_checked(statement, tmp_path):
    solve(callback=Recorder(tmp_path))
    with closing(sqlite3.connect(tmp_path / "record.sqlite")) as database, database:
        database.execute(statement)
    with pytest.raises(ValueError, match=SPOILED[statement]) as told:
        read_record(tmp_path)
    assert str(told.value).startswith(str(tmp_path / "record.sqlite"))


@pytest.mark.parametrize("dtype", ["O", "|O8", "<U8", "<M8", "<f8, <f8"])
def test_nothing_but_numbers_is_read(dtype, tmp_path, monkeypatch):
    solve(callback=Recorder(tmp_path))
    names, _ = record_file.read(tmp_path)
    with closing(sqlite3.connect(tmp_path / "record.sqlite")) as database, database:
        ((rows,),) = database.execute("SELECT candidates FROM generations WHERE number = 1")
        check = record_file.crc32_of(names, 1, dtype, rows)
        database.execute(
            "UPDATE generations SET dtype = ?, crc32 = ? WHERE number = 1", [dtype, check]
        )
    with pytest.raises(ValueError, match=r"dtype = .*: expected one of numbers"):
        read_record(tmp_path)


def test_a_record_is_read_where_nothing_may_be_written_and_leaves_nothing(tmp_path):
    solve(callback=Recorder(tmp_path))
    table = read_record(tmp_path)
    (tmp_path / "record.sqlite").chmod(0o400)
    tmp_path.chmod(0o500)
    try:
        assert read_record(tmp_path).equals(table)
        assert len(list(tmp_path.iterdir())) == 1
    finally:
        tmp_path.chmod(0o700)


@pytest.mark.parametrize("kind", ["link", "folder", *(["fifo"] if hasattr(os, "mkfifo") else [])])
def test_only_a_file_is_opened(kind, tmp_path):
    precious = tmp_path / "precious"
    precious.write_bytes(b"")
    path = tmp_path / "run" / "record.sqlite"
    path.parent.mkdir()
    {
        "link": lambda: path.symlink_to(precious),
        "folder": path.mkdir,
        "fifo": lambda: os.mkfifo(path),
    }[kind]()
    with pytest.raises(ValueError, match="is a link, a folder, a pipe or a device"):
        read_record(path.parent)
    if kind == "folder":
        with pytest.raises(OSError, match=r"record\.sqlite"):
            solve(callback=Recorder(path.parent, overwrite=True))
    else:  # replaced, and nothing written through it
        solve(callback=Recorder(path.parent, overwrite=True))
        assert len(read_record(path.parent)) == 120
    assert precious.read_bytes() == b""


def test_an_empty_record_has_its_columns(tmp_path):
    recorder = Recorder(tmp_path)

    class Stop(Exception):
        pass

    def stop(*_):
        raise Stop

    recorder.flush()  # nothing yet
    assert not any(tmp_path.iterdir())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("mgeo.store.record_file.append", stop)
        with pytest.raises(Stop):
            solve(callback=recorder)
    assert list(read_record(tmp_path)) == ["generation", "x1", "x2", "x3", "f1", "f2", "failed"]
    assert len(read_record(tmp_path)) == 0
