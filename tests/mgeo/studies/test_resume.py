"""A study in a folder is continued only if asked, and only if it is the same study."""

import json
import shutil
from types import SimpleNamespace

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.operators.crossover.sbx import SBX
from pymoo.problems.functional import FunctionalProblem
from pymoo.problems.multi import ZDT1

from mgeo import MGEOReal, compare
from mgeo.store.atomic import lock_folder
from mgeo.studies import Comparison, read_comparison

from .problems import FailingNSGA2

pytestmark = pytest.mark.usefixtures("quick")


class Beam(ZDT1):
    """A problem with a parameter, which its options name."""

    def __init__(self, load=1.0):
        super().__init__(n_var=4)
        self.load = load

    def to_options(self):
        return {"load": self.load}


def algorithms(**changes):
    options = {"pop_size": 10, "crossover": SBX(eta=15)} | changes
    return {"MGEO": MGEOReal(0.1, n_walkers=3), "NSGA-II": NSGA2(**options)}


def study(folder, problem=None, searches=None, n_eval=60, seeds=2, **options):
    return compare(
        problem or Beam(), searches or algorithms(), n_eval, seeds, folder=folder, **options
    )


def stored(folder):
    return {path: path.stat().st_mtime_ns for path in (folder / "runs").iterdir()}


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """The folder of a finished study, and its comparison."""
    folder = tmp_path_factory.mktemp("first")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Comparison, "draw_figures", lambda self: {})
        return folder, study(folder)


@pytest.fixture
def folder(first, tmp_path):
    """A copy of that folder."""
    return shutil.copytree(first[0], tmp_path / "study")


def test_a_folder_that_holds_a_study_is_refused_and_unchanged(folder):
    before = {path: path.read_bytes() for path in folder.rglob("*.*") if path.is_file()}
    with pytest.raises(FileExistsError, match=r"holds a study: --resume \(resume=True in Python"):
        study(folder)
    assert {path: path.read_bytes() for path in before} == before


def test_missing_runs_are_made_and_the_others_reused(first, folder, capsys):
    runs = stored(folder)
    assert len(runs) == 4
    lost = min(runs)
    lost.unlink()
    again = study(folder, resume=True)
    assert capsys.readouterr().err == "Beam: reused 3 of 4 runs\n"
    assert again.table.equals(first[1].table)
    after = stored(folder)
    assert after.keys() == runs.keys()
    assert {path for path in runs if after[path] != runs[path]} == {lost}


def test_failed_runs_are_made_again(tmp_path, capsys):
    searches = {"good": NSGA2(pop_size=10), "bad": FailingNSGA2(pop_size=10)}
    for resume in (False, True):
        found = study(tmp_path, searches=searches, resume=resume)
        assert found.runs["status"].tolist() == ["finished"] * 3 + ["failed"]
    assert "reused 3 of 4 runs" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"problem": Beam(load=2.0)}, "problem.options.load = 2.0, expected 1.0"),
        ({"searches": algorithms(crossover=SBX(eta=20))}, "crossover.eta.value = 20, expected 15"),
        ({"searches": {"other": MGEOReal(0.1)}}, "algorithms.MGEO = None"),
        ({"n_eval": 80}, "evaluations = 80, expected 60"),
        ({"seeds": 3}, r"seeds = \[1, 2, 3\], expected \[1, 2\]"),
    ],
)
def test_another_study_is_refused_with_the_first_difference(changes, message, folder):
    runs = stored(folder)
    with pytest.raises(ValueError, match=f"holds another study: .*{message}"):
        study(folder, resume=True, **changes)
    assert stored(folder) == runs


def test_another_version_is_refused_by_name(folder):
    path = folder / "study.json"
    plan = json.loads(path.read_text())
    assert plan["versions"]["numpy"] == np.__version__
    plan["versions"]["numpy"] = "1.0"
    path.write_text(json.dumps(plan))
    with pytest.raises(ValueError, match=rf"versions.numpy = '{np.__version__}', expected '1.0'"):
        study(folder, resume=True)


def test_attributes_of_a_problem_without_options_are_compared(tmp_path):
    def problem(weights):
        made = FunctionalProblem(2, [lambda x: x[0], lambda x: 1 - x[0] + x[1]], xl=0.0, xu=1.0)
        made.weights, made.service = weights, SimpleNamespace(answers=[1, 2])
        return made

    study(tmp_path, problem(np.arange(200)))
    study(tmp_path, problem(np.arange(200)), resume=True)
    with pytest.raises(ValueError, match=r"problem.weights.hash"):
        study(tmp_path, problem(np.arange(200) + 1), resume=True)


def test_a_finished_study_is_read(first):
    folder, found = first
    read = read_comparison(folder, problem=Beam())
    assert read.table.equals(found.table)
    assert read.format_overview().equals(found.format_overview())
    assert read.test_differences().pairs.equals(found.test_differences().pairs)
    for key, record in found.finished_runs.items():
        assert np.array_equal(read.finished_runs[key].front_F, record.front_F)
    with pytest.raises(ValueError, match="made in Python: pass the compared problem"):
        read_comparison(folder)


def test_two_studies_do_not_share_a_folder_at_once(tmp_path):
    with lock_folder(tmp_path), pytest.raises(ValueError, match="is in use"):
        study(tmp_path)


def test_a_damaged_run_is_named(folder):
    path = min(stored(folder))
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(ValueError, match=rf"{path.name}: not the record of a run: .*delete it"):
        study(folder, resume=True)
