"""What the packages say of themselves is one thing: they are released together."""

import re
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROJECTS = [ROOT / "pyproject.toml", *sorted(ROOT.glob("problems/*/pyproject.toml"))]


def project(path):
    return tomllib.loads(path.read_text(encoding="utf-8"))["project"]


def said(*arguments, root=ROOT):
    command = [sys.executable, str(root / ".ci" / "version"), *arguments]
    return subprocess.run(command, capture_output=True, text=True)


def test_one_version_stands_everywhere():
    assert len(PROJECTS) >= 3
    done = said()
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == project(PROJECTS[0])["version"]


def test_a_version_is_set_everywhere_by_one_command(tmp_path):
    for path in [*PROJECTS, ROOT / "CITATION.cff", ROOT / "docs/citing.md", ROOT / ".ci/version"]:
        copy = tmp_path / path.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(path.read_bytes())
    suite = tmp_path / "problems" / "suite" / "pyproject.toml"
    suite.write_text(suite.read_text().replace(f'"{project(suite)["version"]}"', '"9.9.9"', 1))
    assert "problems/suite/pyproject.toml; .ci/version" in said(root=tmp_path).stderr
    assert said("12.4.0rc1", root=tmp_path).stdout == "12.4.0rc1\n"
    assert said(root=tmp_path).stdout == "12.4.0rc1\n"
    assert project(suite)["version"] == "12.4.0rc1"
    assert "mgeo>=12.4.0rc1,<12.5" in project(suite)["dependencies"]
    assert "12.4.0rc1" in (tmp_path / "CITATION.cff").read_text()
    assert said("twelve", root=tmp_path).returncode == 1


@pytest.mark.parametrize("path", PROJECTS[1:], ids=lambda path: path.parent.name)
def test_a_plugin_says_what_the_first_package_says(path):
    first, plugin = project(PROJECTS[0]), project(path)
    for key in ("version", "license", "license-files", "requires-python", "authors"):
        assert plugin[key] == first[key], key
    for kind in ("Development Status", "Operating System", "Programming Language", "Typing"):
        ours, theirs = (
            [c for c in p["classifiers"] if c.startswith(kind)] for p in (first, plugin)
        )
        assert ours == theirs
    both = {**_bounds(first), **_bounds(plugin)}
    assert both == {**_bounds(plugin), **_bounds(first)}  # of what both need, the same versions


def _bounds(declared):
    parts = (re.fullmatch(r"([\w-]+)(?:\[.*\])?(.*)", line) for line in declared["dependencies"])
    return {part[1]: part[2] for part in parts}


@pytest.mark.parametrize("path", PROJECTS, ids=lambda path: path.parent.name)
def test_a_package_knows_its_version(path):
    name = project(path)["name"]
    module = __import__(name.replace("-", "_"))
    assert module.__version__ == metadata.version(name) == project(path)["version"]
