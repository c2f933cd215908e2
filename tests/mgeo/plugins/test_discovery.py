"""Problems and algorithms by the name of a plugin or as ``module:Class``."""

import math
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.plugins.discovery import PluginError, find_plugin, list_plugins
from mgeo.plugins.problems import load_problem, read_scenario
from mgeo.studies import read_comparison

from .claim import claim

pytestmark = pytest.mark.usefixtures("stand_in")


def test_plugins_are_listed_with_distribution_and_imported_on_demand(monkeypatch):
    monkeypatch.delitem(sys.modules, "stand_in", raising=False)
    found = {plugin.name: plugin for plugin in list_plugins()}
    assert (found["cantilever"].distribution, found["cantilever"].version) == ("stand-in", "1.2.3")
    assert {"no-module", "zdt1"} <= set(found)
    assert "stand_in" not in sys.modules
    find_plugin("cantilever").load()
    assert "stand_in" in sys.modules


def test_problem_is_built_by_from_options_or_constructor():
    X = np.array([[0.02, 1.0]])
    mass = 7800 * math.pi / 4 * 0.02**2
    default, heavy = load_problem("cantilever"), load_problem("cantilever", {"preset": "heavy"})
    assert default.evaluate(X)[0, 0] == pytest.approx(mass)
    assert heavy.evaluate(X)[0, 1] == pytest.approx(2 * default.evaluate(X)[0, 1])
    assert load_problem("zdt1", {"n_var": 7}).n_var == 7


@pytest.mark.parametrize(
    ("name", "option", "expected"),
    [
        ("pymoo:zdt1", "n_vars", "n_var"),
        ("pymoo:dtlz2", "n_objs", "k or n_obj or n_var"),
        ("pymoo:zdt2", "replace_nan_values_by", "n_var"),
        ("swallowing:Leaf", "lenght", "length or width"),
        ("swallowing:Deaf", "length", "no options"),
    ],
)
def test_option_that_constructor_would_ignore_is_rejected(
    name, option, expected, tmp_path, monkeypatch
):
    (tmp_path / "swallowing.py").write_text(SWALLOWING)
    monkeypatch.syspath_prepend(str(tmp_path))
    message = rf"unknown option '{option}' of problem '{name}': expected {expected}(;|$)"
    with pytest.raises(ValueError, match=message):
        load_problem(name, {option: 7}, trusted_classes=(name,))
    sys.modules.pop("swallowing", None)


def test_options_of_base_class_are_accepted_if_keywords_are_passed_on(tmp_path, monkeypatch):
    (tmp_path / "passing.py").write_text(SWALLOWING)
    monkeypatch.syspath_prepend(str(tmp_path))
    problem = load_problem(
        "passing:Leaf", {"length": 3.0, "width": 2.0}, trusted_classes=("passing:Leaf",)
    )
    assert (problem.length, problem.width, problem.n_var) == (3.0, 2.0, 2)


def test_problem_reads_files_that_scenario_refers_to(tmp_path, monkeypatch):
    options, scenario = {"beam": "beam.txt"}, str(tmp_path / "mine.toml")
    (tmp_path / "mine.toml").write_text('beam = "beam.txt"\n')
    for name in ("cantilever", "zdt1", "pymoo:zdt1", "missing"):
        assert read_scenario(name, scenario) == options

    def reader(options, folder):
        return {"load": float((folder / options["beam"]).read_text())}

    monkeypatch.setattr(find_plugin("cantilever").load(), "read_files", reader, raising=False)
    with pytest.raises(FileNotFoundError, match=r"beam\.txt"):
        read_scenario("cantilever", scenario)
    (tmp_path / "beam.txt").write_text("3.5")
    assert read_scenario("cantilever", scenario) == {"load": 3.5}
    (tmp_path / "mine.toml").write_text("")
    with pytest.raises(ValueError, match="read_files of problem 'cantilever' raised KeyError: 'b"):
        read_scenario("cantilever", scenario)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("cantilver", r"'cantilver'.*zdt1.*did you mean 'cantilever'\?"),
        ("no-module", r"stand-in 1\.2\.3 cannot be imported: ModuleNotFoundError.*of_nothing"),
        ("no-problem", r"expected a class derived from pymoo.*'stand_in:math'"),
        ("math:pi", "expected a class derived from pymoo.core.problem.Problem"),
        ("pymo/zdt1:x", "expected module:Class"),
    ],
)
def test_invalid_problem_names_are_rejected(name, message):
    with pytest.raises(PluginError, match=message):
        load_problem(name, trusted_classes=(name,))


def test_name_declared_twice_is_rejected_with_both_distributions(tmp_path, monkeypatch):
    claim(tmp_path, "rival", "cantilever")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(PluginError, match=r"'cantilever' is declared by rival 2\.0 and stand-in"):
        load_problem("cantilever")


SWALLOWING = """
from pymoo.core.problem import ElementwiseProblem


class Stem(ElementwiseProblem):
    def __init__(self, length=1.0, **options):
        super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0, **options)
        self.length = length


class Leaf(Stem):
    def __init__(self, *, width=1.0, **options):
        super().__init__(**options)
        self.width = width


class Deaf(ElementwiseProblem):
    def __init__(self, **options):
        super().__init__(n_var=2, n_obj=2, xl=0.0, xu=1.0)
"""

BEAM = """
import numpy as np
from pymoo.core.problem import Problem


class Beam(Problem):
    def __init__(self, length=1.0):
        super().__init__(n_var=2, n_obj=2, xl=0.01, xu=0.1)
        self.length = length

    def _evaluate(self, X, out, *args, **kwargs):
        area = X[:, 0] * X[:, 1]
        out["F"] = np.column_stack([area * self.length, self.length**3 / (area * X[:, 1] ** 2)])

    @classmethod
    def read_files(cls, options, folder):
        return {"length": float((folder / options["from"]).read_text())}
"""


@pytest.fixture
def beam(tmp_path, monkeypatch):
    """Name of a problem class in a module of the current folder."""
    (tmp_path / "own_beam.py").write_text(BEAM)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [path for path in sys.path if path not in ("", ".")])
    yield "own_beam:Beam"
    sys.modules.pop("own_beam", None)


def test_class_is_imported_only_if_user_specifies_it(beam, tmp_path):
    refused = rf"problem '{beam}': its module is imported only if .*: --problem {beam}, in Python"
    with pytest.raises(PluginError, match=refused):
        load_problem(beam)
    (tmp_path / "mine.toml").write_text('from = "l.txt"\n')
    assert read_scenario(beam, "mine.toml") == {"from": "l.txt"}
    assert "own_beam" not in sys.modules
    assert load_problem(beam, {"length": 2.0}, trusted_classes=(beam,)).length == 2.0
    (tmp_path / "l.txt").write_text("3.5")
    assert read_scenario(beam, "mine.toml", trusted_classes=(beam,)) == {"length": 3.5}
    with pytest.raises(ValueError, match=r"unknown option 'n_var' .*: expected length$"):
        load_problem(beam, {"n_var": 3}, trusted_classes=(beam,))


@pytest.mark.slow
def test_class_in_current_folder_works_in_runs_and_studies(beam, tmp_path):
    def run(*words, code=0):
        done = CliRunner().invoke(app, [*words, "-q"], prog_name="mgeo")
        assert done.exit_code == code, done.output + done.stderr
        return done.stderr

    run("solve", beam, "--evaluations", "60", "--out", "run")
    sys.modules.pop("own_beam")
    assert f"is imported only if you specify it: --problem {beam}" in run("resume", "run", code=2)
    assert f"is imported only if you specify it: --problem {beam}" in run("report", "run", code=2)
    study = 'title = "t"\nevaluations = 60\nseeds = 2\n[[algorithms]]\nname = ["mgeo-real"]\n'
    (tmp_path / "study.toml").write_text(f'{study}[[problems]]\nname = "{beam}"\n')
    run("resume", "run", "--problem", beam, "--evaluations", "120")
    run("report", "run", "--problem", beam)
    run("study", "study.toml", "--jobs", "1")
    comparison = read_comparison("studies/study", trusted_classes=[beam])
    assert comparison.rank_algorithms() == ["mgeo-real"]
