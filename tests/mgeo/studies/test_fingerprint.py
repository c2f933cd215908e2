import subprocess
import sys

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.moo.sms import SMSEMOA
from pymoo.operators.crossover.sbx import SBX
from pymoo.problems.multi import ZDT1

from mgeo import MGEOReal
from mgeo.plugins.discovery import PluginError
from mgeo.studies.fingerprint import fingerprint


def test_what_is_made_alike_has_one_and_what_differs_has_another():
    made = [
        lambda: MGEOReal(),
        lambda: MGEOReal(sigma=0.5),
        lambda: MGEOReal(sigma=[1.0, 0.5]),
        lambda: MGEOReal(sampling=np.zeros((30, 2))),
        lambda: MGEOReal(sampling=np.ones((30, 2))),
        lambda: NSGA2(),
        lambda: NSGA2(pop_size=50),
        lambda: NSGA2(crossover=SBX(eta=3)),
        lambda: ZDT1(),
        lambda: ZDT1(n_var=5),
        lambda: {"a": [1, 2.0, {3}], "b": np.float64(1)},
        lambda: {"a": [1, 2.0, {4}], "b": np.float64(1)},
        lambda: np.random.default_rng(1),
        lambda: np.random.default_rng(2),
        lambda: abs,
        lambda: len,
    ]
    prints = [fingerprint(make()) for make in made]
    assert prints == [fingerprint(make()) for make in made]
    assert len(set(prints)) == len(made)


def test_use_does_not_change_a_problem():
    problem = ZDT1(n_var=5)
    before = fingerprint(problem)
    problem.pareto_front()
    problem.evaluate(np.zeros((2, 5)))
    assert fingerprint(problem) == before


def test_a_problem_with_options_is_its_class_and_options():
    attitude = pytest.importorskip("mgeo_attitude")
    problem = attitude.AttitudeManeuverProblem(threads=1)
    before = fingerprint(problem)
    problem.evaluate(np.zeros((1, 12)))  # fills its tables
    assert fingerprint(problem) == before
    assert fingerprint(attitude.AttitudeManeuverProblem(threads=2)) == before
    assert fingerprint(attitude.AttitudeManeuverProblem(n_maneuvers=2)) != before


def test_options_that_fail_are_the_plugins_fault():
    class Broken(ZDT1):
        def options(self):
            raise ImportError("no module")

    with pytest.raises(PluginError, match=r"options of problem .*Broken raised ImportError"):
        fingerprint(Broken())


@pytest.mark.slow
def test_another_process_comes_to_the_same():
    made = "MGEOReal(), SMSEMOA(), {'x', 'y', 'z'}"
    code = (
        "from mgeo import MGEOReal; from pymoo.algorithms.moo.sms import SMSEMOA\n"
        f"from mgeo.studies.fingerprint import fingerprint; print(fingerprint({made}))"
    )
    other = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout
    assert other.strip() == fingerprint(MGEOReal(), SMSEMOA(), {"x", "y", "z"})


def test_what_contains_itself_has_one():
    loop = []
    loop.append(loop)
    assert fingerprint(loop) != fingerprint([])
