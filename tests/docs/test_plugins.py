"""The example package of docs/tutorials/plugin.md: complete, tested and solved."""

import importlib
import json
import re
import shlex
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app

PAGE = (Path(__file__).parents[2] / "docs" / "tutorials/plugin.md").read_text(encoding="utf-8")
FILE = re.compile(r"`([\w/]+\.(?:py|toml))`[^`]*(?:`[^`\n]+`[^`]*)*```\w+\n(.*?)```", re.DOTALL)


@pytest.fixture
def package(tmp_path, monkeypatch):
    """The files of the page in a folder of the path, with the metadata that pip would write."""
    files = dict(FILE.findall(PAGE))
    for name, content in files.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
    project = tomllib.loads(files["pyproject.toml"])["project"]
    info = tmp_path / f"{project['name']}-{project['version']}.dist-info"
    info.mkdir()
    head = "Metadata-Version: 2.1\nName: {name}\nVersion: {version}\nSummary: {description}\n"
    (info / "METADATA").write_text(head.format_map(project))
    lines = [
        f"[{group}]\n{name} = {value}\n"
        for group, entries in project["entry-points"].items()
        for name, value in entries.items()
    ]
    (info / "entry_points.txt").write_text("".join(lines))
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    importlib.invalidate_caches()
    yield tmp_path
    for name in [name for name in sys.modules if name.partition(".")[0] == "reactor"]:
        del sys.modules[name]


def test_the_package_passes_its_own_tests(package):
    names = {}
    exec((package / "tests" / "test_reactor.py").read_text(encoding="utf-8"), names)
    tests = [name for name in names if name.startswith("test_")]
    assert tests == ["test_protocol", "test_best_yield"]
    for name in tests:
        names[name]()


@pytest.mark.slow
def test_the_package_is_solved_by_its_name(package):
    def mgeo(line):
        done = CliRunner().invoke(app, shlex.split(line)[1:], prog_name="mgeo")
        assert done.exit_code == 0, done.output + done.stderr
        return done.stdout

    solve, report = re.findall(r"^mgeo .*", PAGE, re.MULTILINE)[:2]
    found = json.loads(mgeo(f"{solve} --json"))
    assert re.fullmatch(r".* l at .* °C yield .* %", found["recommended"]["summary"])
    front = np.loadtxt(package / found["folder"] / "front.csv", delimiter=",", skiprows=1)
    volume, loss = front[np.argsort(front[:, 2])][:, 2:4].T
    assert len(front) > 20
    assert (np.diff(loss) < 0.0).all()  # a larger reactor loses less
    # at each volume the best temperature, within the limit of the waste, by a fine grid
    from reactor.problem import Reactor

    problem = Reactor()
    temperatures = np.linspace(300.0, 400.0, 2001)
    for v, found_loss in zip(volume[::5], loss[::5], strict=True):
        X = np.column_stack([np.full(2001, v / problem.flow), temperatures])
        F, G = problem.evaluate(X, return_values_of=["F", "G"])
        assert found_loss < F[G[:, 0] <= 0.0, 1].min() + 0.5
    mgeo(report)
    assert (package / found["folder"] / "report.html").is_file()
