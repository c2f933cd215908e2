"""Versions and requirements of the packages, and mgeo without its extras."""

import os
import re
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROJECTS = [ROOT / "pyproject.toml", *sorted(ROOT.glob("problems/*/pyproject.toml"))]


def read_project(path):
    return tomllib.loads(path.read_text(encoding="utf-8"))["project"]


def parse_requirements(declared):
    """Return the version bounds by package name, including the extra ``cli``."""
    lines = declared["dependencies"] + declared.get("optional-dependencies", {}).get("cli", [])
    parts = (re.fullmatch(r"([\w-]+)(?:\[.*\])?(.*)", line) for line in lines)
    return {part[1]: part[2] for part in parts}


def set_version(*arguments, root=ROOT):
    command = [sys.executable, str(root / ".ci" / "version"), *arguments]
    return subprocess.run(command, capture_output=True, text=True)


def test_command_sets_the_version_everywhere(tmp_path):
    assert set_version().stdout.strip() == read_project(PROJECTS[0])["version"]
    others = ("CITATION.cff", "docs/reference/citing.md", ".ci/version")
    for path in [*PROJECTS, *(ROOT / name for name in others)]:
        copy = tmp_path / path.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(path.read_bytes())
    assert set_version("12.4.0rc1", root=tmp_path).stdout == "12.4.0rc1\n"
    assert set_version(root=tmp_path).stdout == "12.4.0rc1\n"
    suite = read_project(tmp_path / "problems" / "suite" / "pyproject.toml")
    assert suite["version"] == "12.4.0rc1"
    assert "mgeo[cli]>=12.4.0rc1,<12.5" in suite["dependencies"]


@pytest.mark.parametrize("path", PROJECTS[1:], ids=lambda path: path.parent.name)
def test_plugin_agrees_with_the_main_package(path):
    first, plugin = read_project(PROJECTS[0]), read_project(path)
    for key in ("version", "license", "requires-python", "authors"):
        assert plugin[key] == first[key], key
    common = parse_requirements(first).keys() & parse_requirements(plugin).keys()
    assert {key: parse_requirements(plugin)[key] for key in common} == {
        key: parse_requirements(first)[key] for key in common
    }


@pytest.mark.parametrize("path", PROJECTS, ids=lambda path: path.parent.name)
def test_package_has_its_version(path):
    name = read_project(path)["name"]
    module = __import__(name.replace("-", "_"))
    assert module.__version__ == metadata.version(name) == read_project(path)["version"]


#: Code that needs no package of the command line.
CORE = """
from pymoo.optimize import minimize
from pymoo.problems.multi import ZDT1

import mgeo
from mgeo import MGEOReal

problem = ZDT1(n_var=4)
assert len(minimize(problem, MGEOReal(n_walkers=2), ("n_eval", 40), seed=1).F)
compared = mgeo.compare(problem, {"a": MGEOReal(n_walkers=2)}, 40, seeds=1)
assert compared.runs["status"].tolist() == ["finished"]
assert "anytime" in compared.draw_figures()
"""

WITHOUT_EXTRA = """
import sys

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {missing}:
            raise ModuleNotFoundError("No module named " + name, name=name)

sys.meta_path.insert(0, Missing())
"""


def list_cli_packages():
    """Return the import names of the packages in the extra ``cli``."""
    return {
        re.match(r"[\w-]+", line)[0].replace("-", "_")
        for line in read_project(PROJECTS[0])["optional-dependencies"]["cli"]
    }


def test_command_without_its_packages_names_the_extra():
    code = WITHOUT_EXTRA.replace("{missing}", repr(list_cli_packages())) + CORE
    code += "from mgeo.__main__ import main\nmain()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stdout) == (1, "")
    assert re.fullmatch(r"Error: .* needs pip install 'mgeo\[cli\]'\n", done.stderr), done.stderr


@pytest.mark.slow
def test_mgeo_works_in_a_new_environment(tmp_path):
    """pip downloads the requirements of mgeo."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}

    def run(*command):
        return subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )

    python = str(tmp_path / "venv" / "bin" / "python")
    run(sys.executable, "-m", "venv", str(tmp_path / "venv"))
    installed = run(python, "-m", "pip", "install", "-q", str(ROOT))
    if "Failed to establish a new connection" in installed.stderr:
        pytest.skip("no network")
    assert installed.returncode == 0, installed.stderr
    completed = run(python, "-c", CORE)
    assert completed.returncode == 0, completed.stderr
    command = run(str(tmp_path / "venv" / "bin" / "mgeo"))
    assert command.returncode == 1
    assert command.stderr.count("\n") == 1
    assert "pip install 'mgeo[cli]'" in command.stderr
