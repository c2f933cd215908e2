"""Data of runs for COCO's post-processing, against its own observer and `cocopp`."""

import shutil
import warnings

import cocoex
import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.problems import get_problem

from mgeo import compare
from mgeo.plugins.problems import load_problem
from mgeo.studies.file import parse_study
from mgeo.studies.run import CocoFolder, Failure, Task, run
from mgeo.studies.study import run_study

NAME = "coco:bbob-biobj/f3/d2/i4"


class Told(NSGA2):
    """Tells what it asked for."""

    asked: list = []  # noqa: RUF012

    def _advance(self, infills=None, **options):
        self.asked.append(infills.get("X"))
        return super()._advance(infills=infills, **options)

    def _initialize_advance(self, infills=None, **options):
        self.asked.append(infills.get("X"))
        return super()._initialize_advance(infills=infills, **options)


def contents(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def by_coco(folder, X, function=3, instance=4, name="one, two"):
    """What COCO's observer writes of these points, told to it directly."""
    options = (
        f'outer_folder: "{folder.parent}" result_folder: {folder.name} algorithm_name: "{name}" '
        "log_nondominated: none log_decision_variables: none"
    )
    level = cocoex.log_level("error")
    suite = cocoex.Suite("bbob-biobj", f"instances: {instance}", "")
    observer = cocoex.Observer("bbob-biobj", options)
    problem = suite.get_problem_by_function_dimension_instance(function, 2, instance, observer)
    for x in X:
        problem(x)
    problem.free()
    cocoex.log_level(level)
    return contents(folder)


def test_data_are_those_of_cocos_own_observer(tmp_path):
    Told.asked.clear()
    place = tmp_path / "data" / "algorithm" / "run"
    task = Task(load_problem(NAME), Told(pop_size=20), 250, 1, CocoFolder(place, "one, two"))
    made = run(task)
    assert made.n_eval == 250
    X = np.concatenate(Told.asked)[:250]  # the last generation goes beyond
    assert contents(place) == by_coco(tmp_path / "theirs", X)
    assert any(path.suffix == ".tdat" for path in contents(place))
    assert [path.name for path in (tmp_path / "data").iterdir()] == ["algorithm"]
    assert np.array_equal(made.F, run(Task(task.problem, NSGA2(pop_size=20), 250, 1)).F)


def test_a_run_is_made_again_where_its_data_are_missing(tmp_path):
    problem, algorithms = load_problem(NAME), {"one, two": NSGA2(pop_size=20)}
    options = {"seeds": 2, "n_jobs": 1, "progress": False, "folder": tmp_path / "runs"}
    compare(problem, algorithms, 100, **options)
    first = compare(problem, algorithms, 100, coco_data=tmp_path / "data", **options)
    (of_algorithm,) = (tmp_path / "data").iterdir()
    assert of_algorithm.name.startswith("one-two~")
    names = [f"bbob-biobj-f3-d2-i4-seed{seed}" for seed in (1, 2)]
    assert sorted(path.name for path in of_algorithm.iterdir()) == names
    before = contents(of_algorithm)
    (of_algorithm / names[0]).rename(tmp_path / "away")
    again = compare(problem, algorithms, 100, coco_data=tmp_path / "data", **options)
    assert contents(of_algorithm) == before
    assert again.table.equals(first.table)


def test_a_run_that_another_process_makes_at_once_is_no_failure(tmp_path, monkeypatch):
    place = tmp_path / "algorithm" / "run"
    task = Task(load_problem(NAME), NSGA2(pop_size=20), 60, 1, CocoFolder(place, "a"))
    assert not isinstance(run(task), Failure)
    made, remove = contents(tmp_path), shutil.rmtree
    monkeypatch.setattr(  # the other puts its own there as soon as it is removed
        shutil, "rmtree", lambda path, **options: path == place or remove(path, **options)
    )
    assert not isinstance(run(task), Failure)
    assert contents(tmp_path) == made


def test_a_run_that_fails_leaves_no_data(tmp_path):
    class Failing(NSGA2):
        def _advance(self, infills=None, **options):
            raise RuntimeError("no")

    place = tmp_path / "algorithm" / "run"
    task = Task(load_problem(NAME), Failing(pop_size=20), 250, 1, CocoFolder(place, "failing"))
    assert isinstance(run(task), Failure)
    assert not contents(tmp_path)


@pytest.mark.parametrize("name", ["bbob-biobj/f55/d3/i2", "bbob/f24/d2/i1"])
def test_cocopp_reads_it(name, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import cocopp

        for seed in (1, 2):  # of "bbob" COCO observes one problem at a time
            coco = CocoFolder(tmp_path / "ours" / str(seed), "ours")
            run(Task(load_problem(f"coco:{name}"), NSGA2(pop_size=20), 300, seed, coco))
        found = cocopp.load(str(tmp_path / "ours"))
    function, dimension = (int(part[1:]) for part in name.split("/")[1:3])
    (data,) = found
    assert (data.funcId, data.dim) == (function, dimension)
    assert data.maxevals.tolist() == [300, 300]


def test_other_problems_have_no_data_for_coco(tmp_path):
    with pytest.raises(ValueError, match="for COCO of ZDT1: expected one of COCO's functions"):
        compare(get_problem("zdt1"), [NSGA2()], 100, coco_data=tmp_path)
    text = """
    title = "both"
    evaluations = 40
    seeds = 1
    problems = [{ name = "coco:bbob/f1/d2/i1" }, { name = "pymoo:zdt1" }]
    algorithms = [{ name = "nsga2", population = 20 }]
    """
    with pytest.raises(ValueError, match="for COCO of ZDT1: expected one of COCO's functions"):
        run_study(parse_study(text, tmp_path), tmp_path / "out", coco_data=tmp_path / "data")
    assert not list(tmp_path.iterdir())
    coco = CocoFolder(tmp_path / "algorithm" / "run", 'a"b')
    failed = run(Task(load_problem(NAME), NSGA2(), 100, 1, coco))
    assert "COCO's observer: 'a\"b': expected no quotation mark" in failed.error
