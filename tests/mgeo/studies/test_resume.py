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

pytestmark = pytest.mark.usefixtures("without_figures")


class Beam(ZDT1):
    """Problem with a load, which its options contain."""

    def __init__(self, load=1.0):
        super().__init__(n_var=4)
        self.load = load

    def to_options(self):
        return {"load": self.load}


def build_algorithms(**changes):
    options = {"pop_size": 10, "crossover": SBX(eta=15)} | changes
    return {"MGEO": MGEOReal(0.1, n_walkers=3), "NSGA-II": NSGA2(**options)}


def run_comparison(folder, problem=None, algorithms=None, n_eval=60, seeds=2, **options):
    return compare(
        problem or Beam(), algorithms or build_algorithms(), n_eval, seeds, folder=folder, **options
    )


def list_run_files(folder):
    return {path: path.stat().st_mtime_ns for path in (folder / "runs").iterdir()}


@pytest.fixture(scope="module")
def finished_study(tmp_path_factory):
    """Return the folder of a finished study and its comparison."""
    folder = tmp_path_factory.mktemp("first")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Comparison, "draw_figures", lambda self: {})
        return folder, run_comparison(folder)


@pytest.fixture
def folder(finished_study, tmp_path):
    """Return a copy of the folder of the finished study."""
    return shutil.copytree(finished_study[0], tmp_path / "study")


def test_folder_with_a_study_is_rejected_and_unchanged(folder):
    before = {path: path.read_bytes() for path in folder.rglob("*.*") if path.is_file()}
    with pytest.raises(FileExistsError, match=r"contains a study: continue it with --resume"):
        run_comparison(folder)
    assert {path: path.read_bytes() for path in before} == before


def test_resumed_study_repeats_only_missing_runs(finished_study, folder, capsys):
    files = list_run_files(folder)
    assert len(files) == 4
    removed = min(files)
    removed.unlink()
    resumed = run_comparison(folder, resume=True)
    assert capsys.readouterr().err == "Beam: reused 3 of 4 runs\n"
    assert resumed.table.equals(finished_study[1].table)
    after = list_run_files(folder)
    assert after.keys() == files.keys()
    assert {path for path in files if after[path] != files[path]} == {removed}


def test_resumed_study_repeats_failed_runs(tmp_path, capsys):
    algorithms = {"good": NSGA2(pop_size=10), "bad": FailingNSGA2(pop_size=10)}
    for resume in (False, True):
        comparison = run_comparison(tmp_path, algorithms=algorithms, resume=resume)
        assert comparison.runs["status"].tolist() == ["finished"] * 3 + ["failed"]
    assert "reused 3 of 4 runs" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"problem": Beam(load=2.0)}, "problem.options.load = 2.0, expected 1.0"),
        (
            {"algorithms": build_algorithms(crossover=SBX(eta=20))},
            "crossover.eta.value = 20, expected 15",
        ),
        ({"algorithms": {"other": MGEOReal(0.1)}}, "algorithms.MGEO = None"),
        ({"n_eval": 80}, "evaluations = 80, expected 60"),
        ({"seeds": 3}, r"seeds = \[1, 2, 3\], expected \[1, 2\]"),
    ],
)
def test_resuming_a_different_study_reports_first_difference(changes, message, folder):
    files = list_run_files(folder)
    with pytest.raises(ValueError, match=f"contains another study: .*{message}"):
        run_comparison(folder, resume=True, **changes)
    assert list_run_files(folder) == files


def test_resuming_with_another_version_reports_the_package(folder):
    path = folder / "study.json"
    plan = json.loads(path.read_text())
    assert plan["versions"]["numpy"] == np.__version__
    plan["versions"]["numpy"] = "1.0"
    path.write_text(json.dumps(plan))
    with pytest.raises(ValueError, match=rf"versions.numpy = '{np.__version__}', expected '1.0'"):
        run_comparison(folder, resume=True)


def test_attributes_of_problem_without_options_must_be_equal(tmp_path):
    def problem(weights):
        functional = FunctionalProblem(
            2, [lambda x: x[0], lambda x: 1 - x[0] + x[1]], xl=0.0, xu=1.0
        )
        functional.weights, functional.service = weights, SimpleNamespace(answers=[1, 2])
        return functional

    run_comparison(tmp_path, problem(np.arange(200)))
    run_comparison(tmp_path, problem(np.arange(200)), resume=True)
    with pytest.raises(ValueError, match=r"problem.weights.hash"):
        run_comparison(tmp_path, problem(np.arange(200) + 1), resume=True)


def test_finished_study_is_read_back(finished_study):
    folder, comparison = finished_study
    read = read_comparison(folder, problem=Beam())
    assert read.table.equals(comparison.table)
    assert read.format_overview().equals(comparison.format_overview())
    assert read.test_differences().pairs.equals(comparison.test_differences().pairs)
    for key, record in comparison.finished_runs.items():
        assert np.array_equal(read.finished_runs[key].front_F, record.front_F)
    with pytest.raises(ValueError, match="made in Python: pass the compared problem"):
        read_comparison(folder)


def test_locked_folder_is_rejected(tmp_path):
    with lock_folder(tmp_path), pytest.raises(ValueError, match="is in use"):
        run_comparison(tmp_path)


def test_damaged_run_file_is_named(folder):
    path = min(list_run_files(folder))
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(ValueError, match=rf"{path.name}: not a stored run: .*delete the file"):
        run_comparison(folder, resume=True)
