"""What makes two problems or algorithms one, and what nobody can know for certain."""

import functools
import importlib
import io
import logging
import random
import sqlite3
import subprocess
import sys
import threading
import types
import weakref

import numpy as np
import pandas as pd
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.moo.sms import SMSEMOA
from pymoo.core.problem import Problem
from pymoo.core.variable import Integer, Real
from pymoo.operators.crossover.sbx import SBX
from pymoo.problems.multi import ZDT1
from scipy.interpolate import CubicSpline

from mgeo import MGEOReal, compare
from mgeo.plugins.discovery import PluginError
from mgeo.studies.fingerprint.modules import UncertainError
from mgeo.studies.fingerprint.parts import fingerprint

from .problems import Element, Half


class Holder(ZDT1):
    """Holds anything."""

    def __init__(self, **attributes):
        super().__init__(n_var=2)
        vars(self).update(attributes)


class Mixed(Problem):
    def __init__(self, names=("a", "b"), high=5):
        kinds = {"a": Real(bounds=(0, 1)), "b": Integer(bounds=(0, high))}
        super().__init__(vars={name: kinds[name] for name in names}, n_obj=2)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = [[x["a"], x["b"] - x["a"]] for x in X]


class Optional(Problem):
    """What its options do not tell is changed after it was made."""

    def __init__(self, scale=1.0):
        self.scale, self.offset = scale, 0.0
        super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)

    def options(self):
        return {"scale": self.scale}

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = self.scale * X * [1, -1] + self.offset


class Asked:
    """It keeps what it was asked for."""

    @functools.cached_property
    def answer(self):
        return np.ones(2)


class Restored:
    """Its copy has its attributes in another order, as that of a spline since SciPy 1.18."""

    def __init__(self):
        self.values, self.namespace = np.ones(3), np

    def __getstate__(self):
        return vars(self) | {"namespace": self.namespace.__name__}

    def __setstate__(self, state):
        self.namespace = importlib.import_module(state["namespace"])
        self.values = state["values"]


def closure(scale):
    return lambda x: scale * x


def with_attributes(thing, **attributes):
    vars(thing).update(attributes)
    return thing


MADE = {
    "MGEO": lambda: MGEOReal(),
    "a parameter": lambda: MGEOReal(sigma=0.5),
    "a list": lambda: MGEOReal(sigma=[1.0, 0.5]),
    "an array": lambda: MGEOReal(sampling=np.zeros((30, 2))),
    "another array": lambda: MGEOReal(sampling=np.ones((30, 2))),
    "NSGA-II": lambda: NSGA2(),
    "its population": lambda: NSGA2(pop_size=50),
    "an operator's parameter": lambda: NSGA2(crossover=SBX(eta=3)),
    "ZDT1": lambda: ZDT1(),
    "its size": lambda: ZDT1(n_var=5),
    "options": lambda: Optional(),
    "another option": lambda: Optional(2.0),
    "an attribute beside its options": lambda: with_attributes(Optional(), offset=50.0),
    "bounds": lambda: with_attributes(Optional(), xu=np.full(2, 0.5)),
    "bounds below": lambda: with_attributes(Optional(), xl=np.full(2, -0.5)),
    "mixed": lambda: Mixed(),
    "order of variables": lambda: Mixed(("b", "a")),
    "bounds of a variable": lambda: Mixed(high=6),
    "type of variables": lambda: with_attributes(Optional(), vtype=int),
    "nothing": lambda: Holder(model=None),
    "closure": lambda: Holder(model=closure(1)),
    "closure of another": lambda: Holder(model=closure(2)),
    "partial of a closure": lambda: Holder(model=functools.partial(closure(1), 2)),
    "vectorize": lambda: Holder(model=np.vectorize(closure(1))),
    "bound method": lambda: Holder(model={"a": 1}.get),
    "set": lambda: Holder(model={"a", "b", "c"}),
    "frozenset": lambda: Holder(model=frozenset({"a", "b", "c"})),
    "Generator": lambda: Holder(model=np.random.default_rng(1)),
    "its seed": lambda: Holder(model=np.random.default_rng(2)),
    "DataFrame": lambda: Holder(model=pd.DataFrame({"a": [1.0, 2.0]})),
    "name in a DataFrame": lambda: Holder(model=pd.DataFrame({"b": [1.0, 2.0]})),
    "spline": lambda: Holder(model=CubicSpline([0, 1, 2], [0, 1, 2])),
    "values of a spline": lambda: Holder(model=CubicSpline([0, 1, 2], [0, 1, 3])),
    "restored": lambda: Holder(model=Restored()),
    "ufunc": lambda: Holder(model=np.sin),
    "another ufunc": lambda: Holder(model=np.cos),
    "function of NumPy": lambda: Holder(model=np.mean),
    "logger": lambda: Holder(model=logging.getLogger("a")),
    "sign of zero": lambda: Holder(model=-0.0),
    "zero": lambda: Holder(model=0.0),
    "integer": lambda: Holder(model=0),
    "bool": lambda: Holder(model=False),
}


def test_what_is_made_alike_has_one_and_what_differs_has_another():
    prints = {name: fingerprint(make()) for name, make in MADE.items()}
    assert prints == {name: fingerprint(make()) for name, make in MADE.items()}
    alike = {}
    for name, found in prints.items():
        alike.setdefault(found, []).append(name)
    assert [names for names in alike.values() if len(names) > 1] == []


def test_what_was_changed_after_it_was_made_does_not_take_anothers_runs(tmp_path):
    best = []
    for changes in ({}, {"offset": 50.0}, {"xu": np.full(2, 0.5)}):
        problem = with_attributes(Optional(), **changes)
        found = compare(problem, [NSGA2(pop_size=10)], 40, seeds=1, folder=tmp_path)
        best.append(next(iter(found.records.values())).front_F.min(axis=0))
    assert len(list(tmp_path.iterdir())) == 3
    assert (best[1] > 40).all()
    assert best[2][1] >= -0.5 > best[0][1]


def test_use_does_not_change_a_problem():
    problem = ZDT1(n_var=5)
    before = fingerprint(problem)
    problem.pareto_front()
    problem.evaluate(np.zeros((2, 5)))
    assert fingerprint(problem) == before


def test_what_is_kept_below_a_problem_does_not_change_it():
    problem = Holder(parts=(Asked(),))
    before = fingerprint(problem)
    assert problem.parts[0].answer.any()
    assert fingerprint(problem) == before == fingerprint(Holder(parts=(Asked(),)))


def test_a_part_of_a_table_counts_by_what_it_shows():
    table = np.arange(12.0).reshape(3, 4)
    parts = table[:, ::2], table.T, table[::-1], np.broadcast_to(1.0, (3,)), np.array(["a", 1, {}])
    found = [fingerprint(Holder(part=part)) for part in parts]
    assert found == [fingerprint(Holder(part=part.copy())) for part in parts]
    assert len({*found, fingerprint(Holder(part=table[:, 1::2]))}) == 6


def test_an_attribute_counts_unless_its_class_says_that_it_changes_no_value():
    class Threaded(Holder):
        without_effect = ("threads",)

    one, two = ([fingerprint(kind(threads=n)) for n in (1, 2)] for kind in (Holder, Threaded))
    assert one[0] != one[1]
    assert two[0] == two[1]
    Threaded.without_effect = "threads"  # of which "read" is a part
    with pytest.raises(UncertainError, match=r"Threaded\.without_effect = 'threads': expected a"):
        fingerprint(Threaded(read=1))


@pytest.mark.slow
def test_tables_that_a_problem_fills_do_not_change_it():
    attitude = pytest.importorskip("mgeo_attitude")
    problem = attitude.AttitudeManeuverProblem(threads=1)
    before = fingerprint(problem)
    problem.evaluate(np.zeros((1, 12)))
    assert fingerprint(problem) == before
    assert fingerprint(attitude.AttitudeManeuverProblem(threads=1, n_maneuvers=2)) != before


def test_a_problem_is_looked_at_in_a_copy():
    problem, fresh = Element(), Element()
    state = random.getstate(), np.random.get_state()[1].tolist()  # noqa: NPY002
    assert fingerprint(problem) == fingerprint(fresh)
    assert problem.calls == 0
    assert (random.getstate(), np.random.get_state()[1].tolist()) == state  # noqa: NPY002


class Noisy(ZDT1):
    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["F"] = out["F"] + self.draw(out["F"].shape)


@pytest.mark.parametrize(
    "draw",
    [np.random.default_rng(1).random, lambda shape: np.random.random(shape)],  # noqa: NPY002
)
def test_values_at_random_cannot_be_known(draw):
    problem = with_attributes(Noisy(n_var=2), draw=draw)
    with pytest.raises(UncertainError, match="Noisy gives other values when it is evaluated once"):
        fingerprint(problem)


class Failing(ZDT1):
    """Fails right of a bound."""

    def __init__(self, bound):
        super().__init__(n_var=2)
        self.bound = bound

    def _evaluate(self, X, out, *args, **kwargs):
        if (X[:, 0] > self.bound).any():
            raise ArithmeticError("too far")
        super()._evaluate(X, out)


def test_a_problem_may_fail_at_some_points_but_not_at_all():
    assert fingerprint(Failing(0.5)) == fingerprint(Failing(0.5)) != fingerprint(Failing(0.6))
    assert fingerprint(Half()) == fingerprint(Half())  # is no number at some
    with pytest.raises(UncertainError, match=r"Failing failed at 4 points, with Arith.*: too far"):
        fingerprint(Failing(0.0))


@pytest.mark.slow
@pytest.mark.parametrize("seed", ["1", pytest.param("2", marks=pytest.mark.campaign)])
def test_another_process_comes_to_the_same(seed):
    made = "MGEOReal(), SMSEMOA(), {'x', 'y', 'z'}"
    code = (
        "from mgeo import MGEOReal; from pymoo.algorithms.moo.sms import SMSEMOA\n"
        f"from mgeo.studies.fingerprint import fingerprint; print(fingerprint({made}))"
    )
    other = subprocess.run(
        [sys.executable, "-c", code],
        env={"PYTHONHASHSEED": seed},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert other.strip() == fingerprint(MGEOReal(), SMSEMOA(), {"x", "y", "z"})


UNCERTAIN = {
    "generator": lambda: (i for i in range(3)),
    "Connection": lambda: sqlite3.connect(":memory:"),
    "FileIO": lambda: io.FileIO(__file__),
    "weakref": lambda: weakref.ref(Holder),
    "_thread._local": threading.local,
    "memoryview": lambda: memoryview(b"a"),
    "func": lambda: np.frompyfunc(closure(1), 1, 1),
}


@pytest.mark.parametrize("kind", UNCERTAIN)
@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_what_cannot_be_told_says_so(kind):
    value = UNCERTAIN[kind]()
    within = types.SimpleNamespace(parts={"a": [1, value]})
    for held in (value, within, closure(value)):
        with pytest.raises(
            UncertainError, match=rf"^Holder\.model cannot be looked into: .*{kind}"
        ):
            fingerprint(Holder(model=held))
    if hasattr(value, "close"):
        value.close()


def test_what_pymoo_leaves_out_of_copies_is_not_overlooked():
    problem = with_attributes(ZDT1(n_var=2, exclude_from_serialization=["model"]), model=1.0)
    with pytest.raises(UncertainError, match=r"ZDT1\.model is another one in a copy of it"):
        fingerprint(problem)


def test_what_is_nested_too_deeply_says_so():
    nested = []
    for _ in range(10_000):
        nested = [nested]
    with pytest.raises(UncertainError, match=r"Holder\.model cannot be looked into: maximum"):
        fingerprint(Holder(model=nested))


class Vouched(Holder):
    fingerprint = "tank 3"


def test_an_author_vouches_for_what_cannot_be_told():
    made = Vouched(source=(i for i in range(3)), scale=1.0)
    assert fingerprint(made) == fingerprint(Vouched(source=(i for i in range(3)), scale=1.0))
    # what can be told still counts, and so does the text
    assert fingerprint(made) != fingerprint(Vouched(source=(i for i in range(3)), scale=2.0))
    made.fingerprint = "tank 4"
    assert fingerprint(made) != fingerprint(Vouched(source=(i for i in range(3)), scale=1.0))


def test_a_vouched_text_stands_for_code_and_values():
    bodies = [{}, {"_evaluate": closure(1)}, {"_evaluate": closure(2), "new": property(closure(3))}]
    made = [type("Vouched", (Vouched,), body)(model=closure(i)) for i, body in enumerate(bodies)]
    assert len({fingerprint(each) for each in made}) == 1


@pytest.mark.parametrize("given", [3, "", b"x"])
def test_a_fingerprint_that_is_no_text_is_refused(given):
    with pytest.raises(PluginError, match=r"fingerprint of Holder = .*: expected a text"):
        fingerprint(Holder(fingerprint=given))
