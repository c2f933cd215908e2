import math
import sys
from importlib.metadata import EntryPoint

import numpy as np
import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.plugins.discovery import Plugin, PluginError, find_plugin, installed_plugins
from mgeo.plugins.problems import load_problem, read_files
from mgeo.studies import read_comparison

pytestmark = pytest.mark.usefixtures("stand_in")


def claim(folder, distribution, name, value="stand_in:Cantilever", group="mgeo.problems"):
    """A second distribution with an entry point of this name."""
    info = folder / f"{distribution}-2.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 2.0\n")
    (info / "entry_points.txt").write_text(f"[{group}]\n{name} = {value}\n")


def test_plugins_are_found_with_their_distribution_and_without_importing_them(monkeypatch):
    monkeypatch.delitem(sys.modules, "stand_in", raising=False)
    found = {plugin.name: plugin for plugin in installed_plugins()}
    assert (found["cantilever"].distribution, found["cantilever"].version) == ("stand-in", "1.2.3")
    assert {"no-module", "zdt1"} <= set(found)
    assert "stand_in" not in sys.modules
    find_plugin("cantilever").load()
    assert "stand_in" in sys.modules


def test_a_problem_is_built_by_from_options_or_by_its_constructor():
    X = np.array([[0.02, 1.0]])
    mass = 7800 * math.pi / 4 * 0.02**2
    default, heavy = load_problem("cantilever"), load_problem("cantilever", {"preset": "heavy"})
    assert default.evaluate(X)[0, 0] == pytest.approx(mass)
    assert heavy.evaluate(X)[0, 1] == pytest.approx(2 * default.evaluate(X)[0, 1])
    assert load_problem("zdt1", {"n_var": 7}).n_var == 7


def test_options_that_a_constructor_would_swallow_are_refused():
    with pytest.raises(ValueError, match=r"unknown option 'n_vars' of problem 'zdt1'.*n_var"):
        load_problem("zdt1", {"n_vars": 7})


def test_a_problem_refuses_its_own_options():
    with pytest.raises(ValueError, match="load = -1"):
        load_problem("cantilever", {"load": -1})


def test_files_are_read_by_the_problem_that_reads_any(tmp_path, monkeypatch):
    options = {"beam": "beam.txt"}
    for name in ("cantilever", "zdt1", "pymoo:zdt1", "missing"):
        assert read_files(name, options, tmp_path) is options
    (tmp_path / "beam.txt").write_text("3.5")

    def reader(options, folder):
        return {"load": float((folder / options["beam"]).read_text())}

    monkeypatch.setattr(find_plugin("cantilever").load(), "read_files", reader, raising=False)
    assert read_files("cantilever", options, tmp_path) == {"load": 3.5}
    with pytest.raises(FileNotFoundError, match=r"beam\.txt"):
        read_files("cantilever", options, tmp_path / "elsewhere")
    with pytest.raises(PluginError, match="read_files of problem 'cantilever' raised KeyError: 'b"):
        read_files("cantilever", {}, tmp_path)
    monkeypatch.setattr(find_plugin("cantilever").load(), "read_files", lambda *given: 3)
    with pytest.raises(PluginError, match="read_files of problem 'cantilever' gives 3: expected a"):
        read_files("cantilever", options, tmp_path)


def test_an_unknown_name_is_refused_with_what_is_installed_and_a_suggestion():
    with pytest.raises(PluginError, match=r"'cantilver'.*zdt1; .*did you mean 'cantilever'\?"):
        load_problem("cantilver")


def test_a_name_claimed_twice_is_refused_naming_both_distributions(tmp_path, monkeypatch):
    claim(tmp_path, "rival", "cantilever")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert len([p for p in installed_plugins() if p.name == "cantilever"]) == 2
    with pytest.raises(PluginError, match=r"'cantilever'.*rival 2\.0 and stand-in 1\.2\.3"):
        load_problem("cantilever")
    assert load_problem("zdt1").n_var == 30  # the others still work


def test_a_plugin_that_cannot_be_imported_says_why():
    with pytest.raises(PluginError, match=r"stand-in 1\.2\.3.*ModuleNotFoundError.*of_nothing"):
        load_problem("no-module")


def test_a_plugin_that_is_no_problem_class_is_refused():
    with pytest.raises(PluginError, match=r"expected a class.*'stand_in:math'"):
        load_problem("no-problem")


def test_an_entry_point_without_distribution_still_loads():
    plugin = Plugin("x", "?", "?", EntryPoint("x", "stand_in:Cantilever", "mgeo.problems"))
    assert plugin.load().__name__ == "Cantilever"


def test_nothing_installed_says_what_to_install(monkeypatch):
    monkeypatch.setattr("mgeo.plugins.discovery.entry_points", lambda group: ())
    with pytest.raises(PluginError, match=r"pip install \./problems/attitude"):
        load_problem("attitude")


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
    """The name of a class in a module of the current folder."""
    (tmp_path / "own_beam.py").write_text(BEAM)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [path for path in sys.path if path not in ("", ".")])
    yield "own_beam:Beam"
    sys.modules.pop("own_beam", None)


def test_a_class_of_ones_own_is_imported_only_if_it_is_named(beam, tmp_path):
    refused = rf"problem '{beam}': its module is imported only if .*: --problem {beam}, in Python"
    with pytest.raises(PluginError, match=refused):
        load_problem(beam)
    assert read_files(beam, {"from": "l.txt"}, tmp_path) == {"from": "l.txt"}
    assert "own_beam" not in sys.modules
    assert load_problem(beam, {"length": 2.0}, named=(beam,)).length == 2.0
    (tmp_path / "l.txt").write_text("3.5")
    assert read_files(beam, {"from": "l.txt"}, tmp_path, named=(beam,)) == {"length": 3.5}
    with pytest.raises(ValueError, match=r"unknown option 'n_var' .*: expected length$"):
        load_problem(beam, {"n_var": 3}, named=(beam,))


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("zdt2", "no problem is called 'zdt2': installed are"),
        ("nowhere:Class", "does not load: ModuleNotFoundError"),
        ("math:pi", "expected a class derived from pymoo.core.problem.Problem"),
        ("pymo/zdt1:x", "expected module:Class"),
    ],
)
def test_what_is_no_problem_is_answered_with_the_prefixes(name, said):
    with pytest.raises(PluginError) as refused:
        load_problem(name, named=(name,))
    assert said in str(refused.value)
    assert "test problems have names as pymoo:zdt1, shifted:zdt1, coco:bbob" in str(refused.value)
    for example in ("pymoo:zdt1", "shifted:zdt1"):
        assert load_problem(example).n_obj == 2


@pytest.mark.slow
def test_a_run_and_a_study_of_ones_own_class(beam, tmp_path):
    def run(*words, code=0):
        done = CliRunner().invoke(app, [*words, "-q"], prog_name="mgeo")
        assert done.exit_code == code, done.output + done.stderr
        return done.stderr

    run("solve", beam, "--evaluations", "60", "--out", "made")
    sys.modules.pop("own_beam")
    assert f"is imported only if it is named: --problem {beam}" in run("resume", "made", code=2)
    assert f"is imported only if it is named: --problem {beam}" in run("report", "made", code=2)
    assert "expected 'other:C', as asked" in run("resume", "made", "--problem", "other:C", code=2)
    study = 'title = "t"\nevaluations = 60\nseeds = 2\n[[algorithms]]\nname = ["mgeo-real"]\n'
    (tmp_path / "study.toml").write_text(f'{study}[[problems]]\nname = "{beam}"\n')
    told = run("study", "study.toml", "--dry-run")
    assert f"{beam}: a dry run has no module imported that a file names" in told
    assert "own_beam" not in sys.modules
    run("resume", "made", "--problem", beam, "--evaluations", "120")
    run("report", "made", "--problem", beam)
    others = ["--problem", beam, "--problem", "other:C"]
    run("report", "made", "made", *others)
    assert "--problem is given 2 times: a run has one" in run("report", "made", *others, code=2)
    run("study", "study.toml", "--jobs", "1")
    kept = read_comparison("studies/study", named=[beam])
    assert kept.order() == ["mgeo-real"]
    sys.modules.pop("own_beam")
    with pytest.raises(ValueError, match="its module is imported only if"):
        read_comparison("studies/study")
