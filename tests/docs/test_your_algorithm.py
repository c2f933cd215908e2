"""The variant of docs/how-to/write-an-algorithm.md: its test, its commands and its study."""

import importlib
import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from joblib.externals.loky import get_reusable_executor
from pymoo.problems.multi import ZDT1

from mgeo.runs.algorithms import build_algorithm
from mgeo.store.run_folder import read_run

from .pages import blocks, run

PAGE = "how-to/write-an-algorithm.md"
NAME = "cauchy:MGEOCauchy"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, with the module of the page."""
    (code,) = blocks(PAGE, "python")
    (tmp_path / "cauchy.py").write_text(code, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [path for path in sys.path if path not in ("", ".")])
    yield tmp_path
    sys.modules.pop("cauchy", None)


@pytest.fixture
def installed(folder, monkeypatch):
    """The name of the page's entry point, installed as pip would."""
    name, value = re.search(r"^([\w-]+) = \"(.*)\"$", blocks(PAGE, "toml")[1], re.M).groups()
    info = folder / "cauchy-2.5.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: cauchy\nVersion: 2.5\n")
    (info / "entry_points.txt").write_text(f"[mgeo.algorithms]\n{name} = {value}\n")
    monkeypatch.syspath_prepend(folder)
    importlib.invalidate_caches()
    return name


@pytest.mark.slow
def test_its_own_test(installed):
    names = {}
    exec(blocks(PAGE, "py")[0], names)
    names["test_protocol"]()


@pytest.mark.slow
def test_commands_and_study(folder):
    solve, again = blocks(PAGE, "sh")[0].splitlines()
    run(f"{solve} --evaluations 1800 --quiet")
    first = read_run("runs/cauchy").configuration
    assert (first.algorithm, first.parameters["scale"]) == (NAME, 0.05)
    run(f"{again} --quiet")
    run(f"{solve} --evaluations 9000 --out whole --quiet")
    assert np.array_equal(read_run("runs/cauchy").outcome.X, read_run("whole").outcome.X)
    Path("study.toml").write_text(blocks(PAGE, "toml")[0])
    # worker processes of an earlier test do not know this folder
    get_reusable_executor().shutdown(wait=True)
    found = run("mgeo study study.toml --evaluations 900 --seeds 2 --jobs 2 --json -q")
    assert json.loads(found)["problems"]["zdt1"]["n_finished"] == 6


def test_steps_have_a_cauchy_distribution(folder):
    """Half of them are shorter than the scale, and 6.3 % longer than ten times the scale."""
    problem = ZDT1(n_var=3)
    algorithm = build_algorithm(NAME, {"n_walkers": 2000, "scale": 1e-3}, problem)
    algorithm.setup(problem, seed=3)
    middle = np.full_like(algorithm.walkers, 0.5)
    algorithm.walkers[:] = middle
    steps = np.abs(algorithm.propose()[:, 0] - middle).ravel()
    assert abs((steps < 1e-3).mean() - 0.5) < 4.0 * 0.5 / np.sqrt(steps.size)
    beyond = 1.0 - 2.0 / np.pi * np.arctan(10.0)
    assert abs((steps > 1e-2).mean() - beyond) < 4.0 * np.sqrt(beyond / steps.size)


def test_an_installed_one_is_found_by_its_name(installed):
    assert re.search(rf"^{installed} ", run("mgeo algorithms"), re.MULTILINE)
    run(f"mgeo solve pymoo:zdt1 --algorithm {installed} --walkers 2 --evaluations 60 --out a -q")
    run("mgeo resume a --evaluations 120 -q")
    assert read_run("a").outcome.n_evaluations == 120


def test_a_run_folder_imports_no_module(folder):
    run(f"mgeo solve pymoo:zdt1 --algorithm {NAME} --walkers 2 --evaluations 60 --out made -q")
    sys.modules.pop("cauchy")
    assert f"--algorithm {NAME}" in run("mgeo resume made --evaluations 600", codes=(2,))
    assert "cauchy" not in sys.modules
