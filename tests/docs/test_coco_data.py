"""`docs/studies/coco_data.py` against COCO's own observer and `cocopp`."""

import warnings

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2

from mgeo.plugins.problems import load_problem

cocoex = pytest.importorskip("cocoex")


class Recording(NSGA2):
    """Records the points that it asks for."""

    asked: list = []  # noqa: RUF012

    def _advance(self, infills=None, **options):
        self.asked.append(infills.get("X"))
        return super()._advance(infills=infills, **options)

    def _initialize_advance(self, infills=None, **options):
        self.asked.append(infills.get("X"))
        return super()._initialize_advance(infills=infills, **options)


def contents(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def logged_by_coco(folder, X):
    """Return what COCO's observer writes of points that it evaluates itself."""
    options = (
        f'outer_folder: "{folder.parent}" result_folder: {folder.name} algorithm_name: "one, two" '
        "log_nondominated: none log_decision_variables: none"
    )
    suite = cocoex.Suite("bbob-biobj", "instances: 4", "")
    observer = cocoex.Observer("bbob-biobj", options)
    function = suite.get_problem_by_function_dimension_instance(3, 2, 4, observer)
    for x in X:
        function(x)
    function.free()
    return contents(folder)


def test_the_data_are_those_of_cocos_own_observer_and_cocopp_reads_them(tmp_path):
    from docs.studies.coco_data import log_run

    Recording.asked.clear()
    problem = load_problem("coco:bbob-biobj/f3/d2/i4")
    made = log_run(problem, Recording(pop_size=20), "one, two", 250, 1, tmp_path / "data")
    assert made.n_eval == 250
    X = np.concatenate(Recording.asked)[:250]  # the last generation exceeds the budget
    (place,) = (tmp_path / "data").glob("*/*")
    assert place.name == "bbob-biobj-f3-d2-i4-seed1"
    assert contents(place) == logged_by_coco(tmp_path / "theirs", X)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import cocopp

        (data,) = cocopp.load(str(place))
    assert (data.funcId, data.dim, data.maxevals.tolist()) == (3, 2, [250])
