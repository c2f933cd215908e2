"""Whatever a value holds, another value has another fingerprint, and the same has the same."""

import array
import collections
import copy
import datetime
import decimal
import enum
import fractions
import functools
import io
import logging
import math
import operator
import pathlib
import pickle
import random
import re
import sqlite3
import string
import threading
import types
import uuid
import weakref
import zoneinfo
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import pandas as pd
import pytest
import scipy.interpolate
import scipy.sparse
import scipy.stats
from pymoo.constraints.as_penalty import ConstraintsAsPenalty
from pymoo.core.variable import Integer, Real
from pymoo.problems.functional import FunctionalProblem
from pymoo.problems.multi import BNH, ZDT1

from mgeo.plugins.discovery import PluginError
from mgeo.studies.fingerprint import UncertainError, fingerprint


@dataclass(slots=True)
class Slotted:
    scale: float


@dataclass(frozen=True)
class Frozen:
    scale: float
    parts: list[float] = field(default_factory=list)


class Named(NamedTuple):
    scale: float


class Slots:
    __slots__ = ("__dict__", "scale")

    def __init__(self, scale):
        self.scale = scale
        self.other = 1

    def times(self, x):
        return self.scale * x


class Color(enum.Enum):
    RED = 1
    BLUE = 2


class Sides(enum.Flag):
    LEFT = 1
    RIGHT = 2


class Bag:
    """Has any attribute that is asked for."""

    def __init__(self, scale):
        self.__dict__["scale"] = scale

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return 0


class Scaled(float):
    pass


def closure(scale):
    return lambda x: scale * x


def containing_itself(scale):
    one, other = [scale], {}
    other["one"] = one
    one.append(other)
    return one


VALUES = {
    "None": lambda k: None if k == 1 else False,
    "int": lambda k: k,
    "int or float": lambda k: 1 if k == 1 else 1.0,
    "int or bool": lambda k: 1 if k == 1 else True,
    "large int": lambda k: 10 ** (5000 * k),
    "sign of zero": lambda k: 0.0 if k == 1 else -0.0,
    "nan": lambda k: math.nan if k == 1 else math.inf,
    "complex": lambda k: complex(0, k),
    "bytes": lambda k: bytes(k),
    "bytes or str": lambda k: b"a" if k == 1 else "a",
    "surrogate": lambda k: "\udc80" * k,
    "bytearray": lambda k: bytearray(k),
    "array.array": lambda k: array.array("d", [k]),
    "range": lambda k: range(k),
    "slice": lambda k: slice(k),
    "list or tuple": lambda k: [1] if k == 1 else (1,),
    "grouping": lambda k: [[1], [2, 3]] if k == 1 else [[1, 2], [3]],
    "dict": lambda k: {"a": k},
    "order of a dict": lambda k: dict([("a", 1), ("b", 2)][:: 1 if k == 1 else -1]),
    "set": lambda k: {"a", "b", str(k)},
    "frozenset": lambda k: frozenset({"a", "b", str(k)}),
    "deque": lambda k: collections.deque([1, k]),
    "length of a deque": lambda k: collections.deque([1], maxlen=10 * k),
    "defaultdict": lambda k: collections.defaultdict(list, {"a": [k]}),
    "OrderedDict": lambda k: collections.OrderedDict(a=k),
    "Counter": lambda k: collections.Counter({"a": k}),
    "namedtuple": lambda k: Named(k),
    "simple namespace": lambda k: types.SimpleNamespace(scale=k),
    "mapping proxy": lambda k: types.MappingProxyType({"a": k}),
    "dataclass with slots": lambda k: Slotted(k),
    "frozen dataclass": lambda k: Frozen(1.0, [k]),
    "slots and dict": lambda k: Slots(k),
    "subclass of float": lambda k: Scaled(k),
    "enum": lambda k: Color(k),
    "flags": lambda k: Sides.RIGHT | Sides(2 - k),
    "any attribute": lambda k: [Bag(k)],
    "datetime": lambda k: datetime.datetime(2020, 1, k),
    "time zone": lambda k: datetime.datetime(
        2020, 1, 1, tzinfo=zoneinfo.ZoneInfo("Europe/Berlin" if k == 1 else "America/Sao_Paulo")
    ),
    "date": lambda k: datetime.date(2020, 1, k),
    "timedelta": lambda k: datetime.timedelta(k),
    "Path": lambda k: pathlib.Path(str(k)),
    "Decimal": lambda k: decimal.Decimal(k),
    "Fraction": lambda k: fractions.Fraction(1, k),
    "UUID": lambda k: uuid.UUID(int=k),
    "pattern": lambda k: re.compile("a" * k),
    "Template": lambda k: string.Template("a" * k),
    "random.Random": lambda k: random.Random(k),
    "partial": lambda k: functools.partial(pow, k),
    "partial of a lambda": lambda k: functools.partial(closure(k), 2),
    "closure": lambda k: closure(k),
    "closure in a closure": lambda k: closure(closure(k)),
    "bound method": lambda k: Slots(k).times,
    "bound builtin": lambda k: {"a": k}.get,
    "itemgetter": lambda k: operator.itemgetter(k),
    "attrgetter": lambda k: operator.attrgetter("a" * k),
    "dtype": lambda k: np.dtype("f4" if k == 1 else "f8"),
    "NumPy scalar": lambda k: np.float64(k),
    "NumPy date": lambda k: np.datetime64("2020-01-01", "D" if k == 1 else "s"),
    "array": lambda k: np.array([1.0, k]),
    "shape": lambda k: np.zeros((2, 3) if k == 1 else (3, 2)),
    "type of an array": lambda k: np.zeros(2, dtype="i4" if k == 1 else "f4"),
    "array of objects": lambda k: np.array([None, Slotted(k)], dtype=object),
    "structured array": lambda k: np.array([(1, 2.0)], dtype=[("a", "i4"), ("b" * k, "f8")]),
    "masked array": lambda k: np.ma.masked_equal([1, 2, 3], k),
    "transposed array": lambda k: np.arange(6.0).reshape(2, 3)[:: 1 if k == 1 else -1].T,
    "ufunc": lambda k: np.sin if k == 1 else np.cos,
    "function of NumPy": lambda k: np.mean if k == 1 else np.median,
    "vectorize": lambda k: np.vectorize(closure(k)),
    "poly1d": lambda k: np.poly1d([k, 1]),
    "Generator": lambda k: np.random.default_rng(k),
    "RandomState": lambda k: np.random.RandomState(k),
    "DataFrame": lambda k: pd.DataFrame({"a": [1.0, k]}),
    "names of a DataFrame": lambda k: pd.DataFrame({"a" * k: [1.0]}),
    "index of a DataFrame": lambda k: pd.DataFrame({"a": [1.0]}, index=[f"row {k}"]),
    "Series": lambda k: pd.Series([k, 2.0]),
    "Series of texts": lambda k: pd.Series(["a", str(k)]),
    "Categorical": lambda k: pd.Categorical(["a", "b"], ordered=k == 1),
    "Timestamp": lambda k: pd.Timestamp(2020, 1, k),
    "DatetimeIndex": lambda k: pd.date_range("2020-01-01", periods=3, freq=f"{k}D"),
    "MultiIndex": lambda k: pd.MultiIndex.from_tuples([("a", k), ("b", 2)]),
    "sparse array": lambda k: scipy.sparse.csr_array([[1.0, k]]),
    "sparse matrix": lambda k: scipy.sparse.coo_matrix([[1.0, k]]),
    "CubicSpline": lambda k: scipy.interpolate.CubicSpline([0, 1, 2], [0, 1, k]),
    "BSpline": lambda k: scipy.interpolate.make_interp_spline([0, 1, 2, 3], [0, 1, k, 3]),
    "interp1d": lambda k: scipy.interpolate.interp1d([0, 1], [0, k]),
    "RegularGridInterpolator": lambda k: scipy.interpolate.RegularGridInterpolator(
        ([0.0, 1.0],), np.array([0.0, k])
    ),
    "distribution": lambda k: scipy.stats.norm(loc=k),
    "itself": containing_itself,
    "attribute data": lambda k: ZDT1(n_var=2, kind=k),  # kept in Problem.data
    "attribute cache": lambda k: with_attributes(ZDT1(n_var=2), cache={"scale": k}),
    "elementwise function": lambda k: FunctionalProblem(2, [closure(1), closure(k)]),
    "variables": lambda k: {"a": Real(bounds=(0, 1)), "b": Integer(bounds=(0, k))},
    "wrapped problem": lambda k: ConstraintsAsPenalty(BNH(), penalty=k),
}


def inverse(table):
    found = collections.defaultdict(list)
    for key, value in table.items():
        found[value].append(key)
    return found


def with_attributes(thing, **attributes):
    for name, value in attributes.items():
        setattr(thing, name, value)
    return thing


@pytest.mark.parametrize("name", VALUES)
def test_every_kind_of_value_counts_by_what_it_holds(name):
    make = VALUES[name]
    one, other = fingerprint(make(1)), fingerprint(make(2))
    assert one != other
    assert (one, other) == (fingerprint(make(1)), fingerprint(make(2)))
    assert fingerprint([make(1), make(2)]) != fingerprint([make(2), make(1)])
    if name != "mapping proxy":  # which has no copies
        assert fingerprint(copy.deepcopy(make(1))) == one
    try:
        content = pickle.dumps(make(1))
    except (pickle.PicklingError, AttributeError, TypeError):  # a lambda in it
        return
    assert fingerprint(pickle.loads(content)) == one


def test_all_kinds_differ():
    made = {name: fingerprint(make(2)) for name, make in VALUES.items()}
    alike = [names for names in inverse(made).values() if len(names) > 1]
    assert alike == []


def test_use_does_not_change_a_value():
    frame = pd.DataFrame({"a": [3.0, 1.0], "b": ["x", "y"]})
    spline = scipy.interpolate.CubicSpline([0, 1, 2], [0, 1, 3])
    matrix = scipy.sparse.csr_array([[1.0, 2.0]])
    before = fingerprint([frame, spline, matrix])
    _ = frame["a"].mean(), frame.loc[0], frame.sort_values("a"), spline(0.5), matrix @ [1.0, 2.0]
    assert fingerprint([frame, spline, matrix]) == before


def test_shared_parts_cost_once():
    nested = [1.0]
    for _ in range(200):
        nested = [nested, nested]
    assert fingerprint(nested) == fingerprint(copy.deepcopy(nested))


class Holder(ZDT1):
    def __init__(self, **attributes):
        super().__init__(n_var=2)
        with_attributes(self, **attributes)


def local():
    found = threading.local()
    found.x = 1
    return found


UNCERTAIN = {
    "generator": lambda: (i for i in range(3)),
    "sqlite3.Connection": lambda: sqlite3.connect(":memory:"),
    "_io.FileIO": lambda: io.FileIO(__file__),
    "weakref.ReferenceType": lambda: weakref.ref(Color),
    "_thread._local": local,
    "memoryview": lambda: memoryview(b"a"),
    "numpy.ufunc": lambda: np.frompyfunc(closure(1), 1, 1),
}


@pytest.mark.parametrize("kind", UNCERTAIN)
@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_what_cannot_be_told_says_so(kind):
    value = UNCERTAIN[kind]()
    with pytest.raises(UncertainError, match=rf"^Holder\.source is (a|the) {kind}"):
        fingerprint(Holder(source=value))
    with pytest.raises(UncertainError, match=rf"^Holder\.model\.parts\['a'\]\[1\] is .* {kind}"):
        fingerprint(Holder(model=types.SimpleNamespace(parts={"a": [1, value]})))
    with pytest.raises(UncertainError, match=r"^Holder\.f \(its variable scale\) is "):
        fingerprint(Holder(f=closure(value)))


class Vouched(Holder):
    fingerprint = "tank 3"


def test_an_author_vouches_for_what_cannot_be_told():
    made = Vouched(source=(i for i in range(3)), scale=1.0)
    assert fingerprint(made) == fingerprint(Vouched(source=(i for i in range(3)), scale=1.0))
    # what can be told still counts, and so does the text
    assert fingerprint(made) != fingerprint(Vouched(source=(i for i in range(3)), scale=2.0))
    made.fingerprint = "tank 4"
    assert fingerprint(made) != fingerprint(Vouched(source=(i for i in range(3)), scale=1.0))


def test_a_vouched_text_stands_for_the_code():
    bodies = [{}, {"_evaluate": closure(1)}, {"_evaluate": closure(2), "new": property(closure(3))}]
    prints = {fingerprint(type("Vouched", (Vouched,), body)()) for body in bodies}
    assert len(prints) == 1
    assert fingerprint(type("Vouched", (Vouched,), {"scale": 1.0})()) not in prints


@pytest.mark.parametrize("given", [3, "", b"x"])
def test_a_fingerprint_that_is_no_text_is_refused(given):
    with pytest.raises(PluginError, match=r"fingerprint of Holder = .*: expected a text"):
        fingerprint(Holder(fingerprint=given))


def test_locks_and_loggers_compute_nothing():
    one = Holder(lock=threading.Lock(), again=threading.RLock(), log=logging.getLogger("a"))
    other = Holder(lock=threading.Lock(), again=threading.RLock(), log=logging.getLogger("a"))
    assert fingerprint(one) == fingerprint(other)


def test_what_pymoo_leaves_out_of_copies_is_not_overlooked():
    problem = ZDT1(n_var=2, exclude_from_serialization=["model"])
    problem.model = Frozen(1.0)
    with pytest.raises(UncertainError, match=r"ZDT1\.model is another one in a copy of it"):
        fingerprint(problem)


class Restless:
    """Is another one whenever it is taken apart."""

    def __reduce__(self):
        return Restless, (), {"at": id(object()) + random.random()}


def test_what_is_another_one_in_a_copy_says_so():
    with pytest.raises(UncertainError, match=r"ZDT1\.part is another one in a copy of it"):
        fingerprint(with_attributes(ZDT1(n_var=2), part=Restless()))


def test_what_is_nested_too_deeply_says_so():
    nested = []
    for _ in range(10_000):
        nested = [nested]
    with pytest.raises(UncertainError, match="ZDT1 is nested too deeply"):
        fingerprint(with_attributes(ZDT1(n_var=2), part=nested))
