"""The command as a process, and its help."""

import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest


@pytest.mark.slow
def test_process(tmp_path):
    """As installed: one line on stderr and exit code 2, without importing what is not needed."""
    done = subprocess.run(
        [sys.executable, "-m", "mgeo_attitude", "show", str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr == f"Error: {tmp_path} holds no run: there is no run.json\n"


def test_version(run):
    assert run("--version").stdout == f"mgeo-attitude {version('mgeo-attitude')}\n"


def test_help_names_the_commands(run):
    text = run("--help").stdout
    for command in ("show", "export"):
        assert command in text


def test_the_script_is_declared():
    text = (Path(__file__).parents[3] / "problems/attitude/pyproject.toml").read_text()
    assert 'mgeo-attitude = "mgeo_attitude.cli:main"' in text


def test_tracebacks_on_demand(run, tmp_path):
    assert isinstance(run("show", tmp_path, "--debug", code=1).exception, FileNotFoundError)
