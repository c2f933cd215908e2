"""Whatever a problem computes counts: its functions, its classes, and the code that these use."""

import functools
import importlib
import os
import re
import subprocess
import sys
import textwrap

import numpy as np
import pytest
from pymoo.problems.functional import FunctionalProblem
from pymoo.problems.multi import ZDT1
from scipy.interpolate import CubicSpline

from mgeo.studies.fingerprint.modules import UncertainError
from mgeo.studies.fingerprint.parts import fingerprint

HEAD = """
import functools, math
import numpy as np
from pymoo.core.problem import ElementwiseProblem, Problem
from pymoo.problems.functional import FunctionalProblem

def functional(f):
    return FunctionalProblem(2, [f, lambda x: x[1]], xl=0.0, xu=1.0)
"""
#: Pieces of a script that make a `problem`, with @ in place of a number that makes a difference.
SCRIPTS = {
    "lambda": "problem = functional(lambda x: @ * x[0])",
    "operation": "problem = functional(lambda x: x[0] ** @)",
    "name of a function": "problem = functional(lambda x: (math.sin, math.cos)[@ - 1](x[0]))",
    "default": "problem = functional(lambda x, k=@: k * x[0])",
    "keyword default": "problem = functional(lambda x, *, k=@: k * x[0])",
    "global": "K = @\nproblem = functional(lambda x: K * x[0])",
    "global array": "K = np.full(3, float(@))\nproblem = functional(lambda x: K.sum() * x[0])",
    "global in a nested function": """
        K = @
        def f(x):
            return [(lambda y: K * y)(each) for each in x][0]
        problem = functional(f)
    """,
    "function used": """
        def g(x): return @ * x
        def f(x): return g(x[0])
        problem = functional(f)
    """,
    "function used by one that is used": """
        def h(x): return @ * x
        def g(x): return h(x)
        def f(x): return g(x[0])
        problem = functional(f)
    """,
    "functions that use each other": """
        def g(x): return f(x) if x.sum() > 9 else @
        def f(x): return g(x)
        problem = functional(f)
    """,
    "class used": """
        class Model:
            def value(self, x): return @ * x
        def f(x): return Model().value(x[0])
        problem = functional(f)
    """,
    "nested function": """
        def f(x):
            def g(y): return @ * y
            return g(x[0])
        problem = functional(f)
    """,
    "decorated function": """
        def scaled(k):
            def wrap(g):
                @functools.wraps(g)
                def wrapped(x): return k * g(x)
                return wrapped
            return wrap
        @scaled(@)
        def f(x): return x[0]
        problem = functional(f)
    """,
    "cached function": """
        @functools.lru_cache
        def remembered(x): return @ * x
        problem = functional(lambda x: remembered(float(x[0])))
    """,
    "partial": "problem = functional(functools.partial(lambda k, x: k * x[0], @))",
    "vectorize": """
        g = np.vectorize(lambda x: @ * x)
        problem = functional(lambda x: float(g(x[0])))
    """,
    "method": """
        class P(Problem):
            def __init__(self): super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)
            def _evaluate(self, X, out, *args, **kwargs): out["F"] = @ * X
        problem = P()
    """,
    "method of a base": """
        class Base(Problem):
            def _evaluate(self, X, out, *args, **kwargs): out["F"] = @ * X
        class P(Base):
            def __init__(self): super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)
        problem = P()
    """,
    "attribute of a class": """
        class P(Problem):
            scale = @
            def __init__(self): super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)
            def _evaluate(self, X, out, *args, **kwargs): out["F"] = self.scale * X
        problem = P()
    """,
    "attribute of a class that is set later": """
        class P(Problem):
            scale = 0.0
            def __init__(self): super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)
            def _evaluate(self, X, out, *args, **kwargs): out["F"] = self.scale * X
        problem = P()
        P.scale = @
    """,
    "property": """
        class P(Problem):
            def __init__(self): super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)
            @property
            def scale(self): return @
            def _evaluate(self, X, out, *args, **kwargs): out["F"] = self.scale * X
        problem = P()
    """,
    "cached property": """
        class P(Problem):
            def __init__(self): super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)
            @functools.cached_property
            def scale(self): return @
            def _evaluate(self, X, out, *args, **kwargs): out["F"] = self.scale * X
        problem = P()
    """,
    "static method": """
        class P(Problem):
            def __init__(self): super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)
            @staticmethod
            def scale(X): return @ * X
            def _evaluate(self, X, out, *args, **kwargs): out["F"] = self.scale(X)
        problem = P()
    """,
    "method of an instance": """
        class P(Problem):
            def __init__(self): super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)
            def one(self, X, out, *args, **kwargs): out["F"] = X
            def two(self, X, out, *args, **kwargs): out["F"] = 2 * X
        problem = P()
        problem._evaluate = [problem.one, problem.two][@ - 1]
    """,
    "method put into a class": """
        class P(Problem):
            def __init__(self): super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)
        P._evaluate = lambda self, X, out, *args, **kwargs: out.update(F=@ * X)
        problem = P()
    """,
    "class of an attribute": """
        class Model:
            def value(self, x): return @ * x[0]
        problem = functional(Model().value)
    """,
    "callable object": """
        class Model:
            def __call__(self, x): return @ * x[0]
        problem = functional(Model())
    """,
    "set in the code": "problem = functional(lambda x: float(round(x[0]) in {'a', 'b', @}))",
    "options below the constructor": """
        class P(Problem):
            def __init__(self, k):
                self.k = k
                super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)
            def options(self): return {"k": self.k}
            def _evaluate(self, X, out, *args, **kwargs): out["F"] = self.k * X
        class Q(P):
            def __init__(self, k, scale):
                self.scale = scale
                super().__init__(k)
        problem = Q(1.0, @)
    """,
}


def made(source):
    """The fingerprint of a script's problem, as in a notebook: there is no file."""
    names = {"__name__": "__main__"}
    exec(source, names)
    return fingerprint(names["problem"])


def source_of(name, number):
    """The script with a number in it; @ begins decorators, too."""
    return HEAD + re.sub(r"@(?![a-z])", str(number), textwrap.dedent(SCRIPTS[name]))


@pytest.mark.parametrize("name", SCRIPTS)
def test_every_place_of_a_number_in_code_counts(name):
    one, other = made(source_of(name, 1)), made(source_of(name, 2))
    assert one != other
    # where code stands, and what is said beside it, does not
    assert made("\n# a comment\n" + source_of(name, 1).replace("\ndef", "\n\ndef")) == one


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.parametrize("seed", ["1", "2"])
def test_another_process_comes_to_the_same(seed, tmp_path):
    # of a script's own objects cloudpickle takes neither of these (the second on Python 3.11)
    sendable = [name for name in SCRIPTS if name not in ("cached function", "cached property")]
    keep = "made.append(fingerprint(problem)); found.append(problem)"
    file = tmp_path / "script.py"
    file.write_text(
        "import joblib\nfrom mgeo.studies.fingerprint import fingerprint\nmade, found = [], []\n"
        "def now(problem):\n    try: return fingerprint(problem)\n"
        "    except ValueError: return '-'\n"
        + "\n".join(f"{source_of(name, 1)}\n{keep}" for name in sendable)
        + "\nif __name__ == '__main__':\n"
        "    print(*made)\n"
        "    print(*map(now, found))  # names stand for something else by now, or for nothing\n"
        "    print(*joblib.Parallel(2)(joblib.delayed(now)(each) for each in found))\n"
    )
    environment = {**os.environ, "PYTHONHASHSEED": seed}
    printed = subprocess.run(
        [sys.executable, str(file)], env=environment, capture_output=True, text=True, check=True
    ).stdout
    first, here, workers = (line.split() for line in printed.splitlines())
    assert first == [made(source_of(name, 1)) for name in sendable]
    assert [n for n, a, b in zip(sendable, here, workers, strict=True) if a != b] == []


@pytest.fixture
def forget():
    """Takes back what is known of modules, as if Python were started anew.

    Which distribution has which is read from disk in half a second: only if one has changed.
    """

    def clear(distributions=False):
        importlib.invalidate_caches()
        modules = importlib.import_module("mgeo.studies.fingerprint.modules")
        for cached in vars(modules).values():
            if hasattr(cached, "cache_clear") and (
                distributions or cached is not modules._providers
            ):
                cached.cache_clear()

    yield clear
    clear()


@pytest.fixture
def module(tmp_path, monkeypatch, forget):
    """Writes files and imports a module of them as if Python were started anew."""
    monkeypatch.syspath_prepend(tmp_path)
    names = []

    def write(files, name):
        for each in names:
            sys.modules.pop(each, None)
        names[:] = [path.removesuffix(".py").replace("/", ".") for path in files]
        names.extend(each.removesuffix(".__init__") for each in tuple(names))
        for path, text in files.items():
            (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / path).write_text(textwrap.dedent(text))
        forget()
        return importlib.import_module(name)

    yield write
    for each in names:
        sys.modules.pop(each, None)


PACKAGE = {
    "plant/__init__.py": "",
    "plant/problem.py": """
        from typing import TYPE_CHECKING
        from pymoo.core.problem import Problem
        from .model import output
        if TYPE_CHECKING:
            from .typing_only import Anything
        class Plant(Problem):
            def __init__(self): super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)
            def _evaluate(self, X, out, *args, **kwargs): out["F"] = output(X)
        """,
    "plant/model.py": """
        def output(X):
            from plant.deep.inner import gain
            return gain() * X
        """,
    "plant/deep/__init__.py": "",
    "plant/deep/inner.py": """
        import steel
        def gain(): return steel.STRENGTH
        """,
    "plant/template.txt": "not code",
    "plant/elsewhere/__init__.py": "",
    "plant/elsewhere/figures.py": "x = 1",
    "steel.py": "STRENGTH = 2.0",
}


@pytest.mark.parametrize(
    ("path", "counts"),
    [
        ("plant/problem.py", True),
        ("plant/model.py", True),
        ("plant/deep/inner.py", True),  # imported within a function
        ("steel.py", True),  # a module of its own, imported by one that is
        ("plant/elsewhere/figures.py", False),  # of the package, but imported by none
        ("plant/template.txt", False),
    ],
)
def test_a_package_under_development_counts_by_what_it_imports(module, path, counts):
    one = fingerprint(module(PACKAGE, "plant.problem").Plant())
    changed = {**PACKAGE, path: textwrap.dedent(PACKAGE[path]) + "\nchanged = 1\n"}
    assert (fingerprint(module(changed, "plant.problem").Plant()) != one) is counts
    assert fingerprint(module(PACKAGE, "plant.problem").Plant()) == one


def test_a_package_that_loads_names_by_its_stub_counts_by_what_these_import(module):
    lazy = """
        def __getattr__(name):
            from importlib import import_module
            return getattr(import_module("plant.deep." + "inner"), name)
        """
    model = "def output(X):\n    from plant.deep import gain\n    return gain() * X\n"
    files = {**PACKAGE, "plant/deep/__init__.py": lazy, "plant/model.py": model}
    files["plant/deep/__init__.pyi"] = "from .inner import gain as gain"
    one = fingerprint(module(files, "plant.problem").Plant())
    for path in ("steel.py", "plant/deep/__init__.pyi"):
        changed = {**files, path: files[path] + "\nchanged = 1\n"}
        assert fingerprint(module(changed, "plant.problem").Plant()) != one


def test_code_that_is_read_as_text_counts_with_its_folder(module):
    files = {**PACKAGE, "plant/kernel.py": "k = 1"}  # such as a template of generated code
    one = fingerprint(module(files, "plant.problem").Plant())
    files["plant/kernel.py"] = "k = 2"
    assert fingerprint(module(files, "plant.problem").Plant()) != one


def test_a_script_counts_by_the_modules_it_uses(module):
    for body in ("lambda x: steel.double(x[0])", "lambda x: double(x[0])"):
        prints = []
        for factor in (1, 2):
            module({"steel.py": f"def double(x): return {factor} * x"}, "steel")
            source = f"{HEAD}\nimport steel\nfrom steel import double\nproblem = functional({body})"
            prints.append(made(source))
        assert prints[0] != prints[1]


def test_a_file_that_a_helper_reads_when_it_is_imported_counts_by_what_it_gives(module, tmp_path):
    files = {
        **PACKAGE,
        "plant/table.txt": "2.0",
        "steel.py": """
            from pathlib import Path
            import plant
            STRENGTH = float((Path(plant.__file__).parent / "table.txt").read_text())
            """,
    }
    one = fingerprint(module(files, "plant.problem").Plant())
    assert fingerprint(module(files, "plant.problem").Plant()) == one
    files["plant/table.txt"] = "2.5"
    assert fingerprint(module(files, "plant.problem").Plant()) != one


def test_what_is_changed_in_a_module_after_its_import_counts_by_what_it_gives(module):
    problem = module(PACKAGE, "plant.problem").Plant()
    one = fingerprint(problem)
    steel = importlib.import_module("steel")
    steel.STRENGTH = 3.0
    assert fingerprint(problem) != one
    steel.STRENGTH = 2.0
    plant = type(problem)
    plant._evaluate = lambda self, X, out, *args, **kwargs: out.update(F=2.0 * X)  # the same values
    assert fingerprint(problem) != one


def test_a_method_put_in_the_place_of_another_of_its_file_counts(module):
    text = """
        from dataclasses import dataclass
        from pymoo.algorithms.moo.nsga2 import NSGA2
        @dataclass
        class Model:
            scale: float = 1.0
        class Mine(NSGA2):
            model = Model()
            def _infill(self): return super()._infill()
        def other(self): return None
        """
    mine = module({"mine.py": text}, "mine")
    before = fingerprint(mine.Mine())
    assert fingerprint(mine.Mine()) == before
    mine.Mine._infill = mine.other
    assert fingerprint(mine.Mine()) != before


@pytest.mark.slow
def test_code_that_has_no_file_counts_by_its_content():
    prints = set()
    for step in (1, 2):
        code = (
            "from pymoo.algorithms.moo.nsga2 import NSGA2\n"
            f"class Mine(NSGA2):\n    def _infill(self): return {step}\n"
            "from mgeo.studies.fingerprint import fingerprint; print(fingerprint(Mine()))"
        )
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        )
        prints.add(done.stdout)
    assert len(prints) == 2


def test_a_file_that_is_changed_after_it_was_read_makes_it_uncertain(module, tmp_path):
    problem = module(PACKAGE, "plant.problem").Plant()
    fingerprint(problem)
    (tmp_path / "plant" / "model.py").write_text("def output(X): return X")
    with pytest.raises(UncertainError, match=r"model\.py was changed meanwhile: start Python anew"):
        fingerprint(problem)


def test_a_dynamic_module_cannot_be_told():
    names = {"made": type(sys)("made")}
    exec("f = lambda x: made", names)
    with pytest.raises(UncertainError, match=r"objs: the module made has no file"):
        fingerprint(FunctionalProblem(2, [names["f"]]))


INSTALLED = {
    "site-packages/alloy.py": "def output(x): return x[0]",
    "site-packages/alloy-1.0.dist-info/METADATA": "Name: alloy\nVersion: 1.0\n",
    "site-packages/alloy-1.0.dist-info/RECORD": "alloy.py,sha256=abc,1\n",
}


@pytest.fixture
def installed(tmp_path, monkeypatch, forget):
    monkeypatch.syspath_prepend(tmp_path / "site-packages")

    def install(**files):
        for path, text in {**INSTALLED, **files}.items():
            (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / path).write_text(text)
        sys.modules.pop("alloy", None)
        forget(distributions=True)
        alloy = importlib.import_module("alloy")
        return FunctionalProblem(2, [alloy.output, functools.partial(alloy.output)])

    yield install
    sys.modules.pop("alloy", None)
    forget(distributions=True)


@pytest.mark.slow
def test_a_distribution_counts_by_its_version(installed):
    info = "site-packages/alloy-1.0.dist-info/"
    one = fingerprint(installed())
    metadata = {info + "METADATA": "Name: alloy\nVersion: 1.1\n"}
    assert fingerprint(installed(**metadata)) != one
    assert fingerprint(installed()) == one
    # of one that was installed from a folder the version says little: there its files count
    local = {info + "direct_url.json": '{"dir_info": {}, "url": "file:///alloy"}'}
    two = fingerprint(installed(**local))
    changed = local | {info + "RECORD": "alloy.py,sha256=abd,1\n"}
    assert len({one, two, fingerprint(installed(**changed))}) == 3


def test_numpy_scipy_and_python_count_by_name(monkeypatch, forget):
    values = [np.mean, np.sin, functools.partial(pow, 2), CubicSpline([0, 1], [0, 2]), ZDT1]
    before = [fingerprint(value) for value in values]
    forget()
    monkeypatch.setattr(
        "mgeo.studies.fingerprint.modules._identity", lambda owner: f"{owner.name} 99.0"
    )
    after = [fingerprint(value) for value in values]
    assert after[:-1] == before[:-1]
    assert after[-1] != before[-1]  # pymoo's version is that of a problem


def test_an_evaluation_changes_nothing():
    for name in SCRIPTS:
        names = {"__name__": "__main__"}
        exec(source_of(name, 1), names)
        problem = names["problem"]
        before = fingerprint(problem)
        problem.evaluate(np.full((3, 2), 0.5))
        assert fingerprint(problem) == before, name


def test_compiled_functions_count_by_their_source():
    numba = pytest.importorskip("numba")
    prints = set()
    for fast in (False, True):
        for k in (1.0, 2.0):
            f = numba.njit(lambda x, k=k: k * x, fastmath=fast)
            before = fingerprint(ZDT1(n_var=2, f=f))
            f(1.0)  # compiles it
            assert fingerprint(ZDT1(n_var=2, f=f)) == before
            prints.add(before)
    assert len(prints) == 4
