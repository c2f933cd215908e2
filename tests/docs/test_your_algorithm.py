"""The variant of docs/your-algorithm.md: complete, named in every way, and what it says it is."""

import importlib
import json
import re
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.problems.multi import ZDT1
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.runs.algorithms import build_algorithm, complete_parameters
from mgeo.store.run_folder import read_run
from mgeo.studies import read_study

PAGE = (Path(__file__).parents[2] / "docs" / "your-algorithm.md").read_text(encoding="utf-8")
NAME = "cauchy:MGEOCauchy"


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


def run(command, code=0):
    done = CliRunner().invoke(app, shlex.split(command)[1:], prog_name="mgeo")
    assert done.exit_code == code, command + done.output + done.stderr
    return done


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the module, in which one stands; it is on no path of Python's."""
    (code,) = blocks("python")
    assert len([line for line in code.splitlines() if line]) <= 30
    (tmp_path / "cauchy.py").write_text(code, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [path for path in sys.path if path not in ("", ".")])
    yield tmp_path
    sys.modules.pop("cauchy", None)


@pytest.fixture
def installed(folder, monkeypatch):
    """The same with the page's entry point, as a distribution has it."""
    entry = blocks("toml")[1]
    name, value = re.search(r"^([\w-]+) = \"(.*)\"$", entry, re.MULTILINE).groups()
    site = folder / "site"
    info = site / "cauchy-2.5.dist-info"
    info.mkdir(parents=True)
    (folder / "cauchy.py").rename(site / "cauchy.py")
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: cauchy\nVersion: 2.5\n")
    (info / "entry_points.txt").write_text(f"[mgeo.algorithms]\n{name} = {value}\n")
    monkeypatch.syspath_prepend(site)
    importlib.invalidate_caches()
    return name


@pytest.mark.slow
def test_it_passes_its_own_test(installed):
    names = {}
    exec(blocks("py")[0], names)
    names["test_protocol"]()


@pytest.mark.slow
def test_the_commands_and_the_study(folder):
    solve, again = blocks("sh")[0].splitlines()
    run(f"{solve} --evaluations 600 --quiet")
    first = read_run("runs/cauchy")
    assert first.configuration.algorithm == NAME
    assert first.configuration.parameters == {
        "scale": 0.05,
        "tau": 3.0,
        "n_walkers": 30,
        "restart": "never",
        "patience": 50,
    }
    run(f"{again} --quiet")
    run(f"{solve} --evaluations 9000 --out whole --quiet")
    whole = read_run("whole").outcome
    assert np.array_equal(read_run("runs/cauchy").outcome.X, whole.X)
    Path("study.toml").write_text(blocks("toml")[0])
    study = read_study("study.toml").reduced(evaluations=600, seeds=2)
    assert [each.label for each in study.algorithms] == [
        "Cauchy, 0.02",
        "Cauchy, 0.05",
        "mgeo-real",
    ]
    found = run("mgeo study study.toml --evaluations 600 --seeds 2 --jobs 2 --json -q").stdout
    assert json.loads(found)["problems"]["zdt1"]["runs_finished"] == 6


def test_its_steps_are_cauchys(folder):
    """Half of them are shorter than the scale, and 6.3 % longer than ten times that."""
    problem = ZDT1(n_var=3)
    algorithm = build_algorithm(NAME, {"n_walkers": 2000, "scale": 1e-3}, problem)
    algorithm.setup(problem, seed=3)
    middle = np.full_like(algorithm.walkers, 0.5)
    algorithm.walkers[:] = middle
    steps = np.abs(algorithm.propose()[:, 0] - middle).ravel()
    assert abs((steps < 1e-3).mean() - 0.5) < 4.0 * 0.5 / np.sqrt(steps.size)
    beyond = 1.0 - 2.0 / np.pi * np.arctan(10.0)
    assert abs((steps > 1e-2).mean() - beyond) < 4.0 * np.sqrt(beyond / steps.size)


@pytest.mark.slow
def test_an_installed_one_is_known_by_its_name(installed):
    listed = run("mgeo algorithms").stdout
    assert re.search(rf"^{installed} +{installed} +Walkers that", listed, re.MULTILINE)
    told = run(f"mgeo algorithms {installed}").stdout
    assert re.search(r"^scale ", told, re.MULTILINE)
    assert "--set NAME=VALUE" in told
    run(f"mgeo solve pymoo:zdt1 --algorithm {installed} --evaluations 300 --out named -q")
    assert run("mgeo resume named --evaluations 1800 -q").output == ""
    assert read_run("named").outcome.evaluations == 1800
    with pytest.raises(ValueError, match=r"'mgeo-cauchi'.*did you mean 'mgeo-cauchy'\?"):
        complete_parameters("mgeo-cauchi", {})


def test_no_file_has_a_module_imported(folder):
    run(f"mgeo solve pymoo:zdt1 --algorithm {NAME} --evaluations 300 --out made -q")
    sys.modules.pop("cauchy")
    refused = run("mgeo resume made --evaluations 600", code=2)
    assert f"imported only if it is named: --algorithm {NAME}" in refused.stderr
    assert "cauchy" not in sys.modules
    refused = run("mgeo resume made --algorithm other:Class", code=2)
    assert "expected 'other:Class', as asked for" in refused.stderr


class Small(NSGA2):
    def __init__(self, pop_size=12, eager=False, **options):
        if pop_size < 4:
            raise RuntimeError("too small")
        super().__init__(pop_size=pop_size, **options)
        self.eager = eager


def test_one_that_is_not_of_the_family():
    """Its plain parameters are told and set; pymoo's own and operators are left alone."""
    name = f"{__name__}:Small"
    assert complete_parameters(name, {"eager": True}) == {"pop_size": 12, "eager": True}
    known = complete_parameters("pymoo.algorithms.moo.nsga2:NSGA2", {})
    assert known == {"pop_size": 100}  # the rest are operators and the like
    assert build_algorithm(name, {"pop_size": 8}, ZDT1()).pop_size == 8
    with pytest.raises(ValueError, match="has no parameter 'seed': expected pop_size, eager"):
        complete_parameters(name, {"seed": 1})
    with pytest.raises(ValueError, match="cannot be built: RuntimeError: too small"):
        build_algorithm(name, {"pop_size": 2}, ZDT1())
