import math
import sys
from importlib.metadata import EntryPoint

import numpy as np
import pytest

from mgeo.plugins.discovery import (
    Plugin,
    PluginError,
    find_plugin,
    installed_plugins,
    load_problem,
    read_files,
)

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
    with pytest.raises(PluginError, match=r"'cantilver'.*zdt1; did you mean 'cantilever'\?"):
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
