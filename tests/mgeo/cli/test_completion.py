"""What shells offer, asked for as their scripts do."""

import shutil
import subprocess
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app


def offered(line, shell="bash"):
    """What is offered at the end of a command line."""
    words = line.split(" ")
    environment = {
        "_MGEO_COMPLETE": f"complete_{shell}",
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(words) - 1),
        "_TYPER_COMPLETE_ARGS": line,
    }
    done = CliRunner().invoke(app, [], prog_name="mgeo", env=environment)
    return done.stdout.split()


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("mgeo so", ["solve"]),
        ("mgeo solve canti", ["cantilever"]),
        ("mgeo solve --algorithm mgeo-real", ["mgeo-real", "mgeo-real2"]),
        ("mgeo solve --perturbation r", ["relative", "range"]),
        ("mgeo solve cantilever --scenario ", ["heavy", "light", "mine.toml", "more/", "runs/"]),
        ("mgeo solve --scenario h", []),
        ("mgeo solve cantilever --scenario more/", ["more/other.toml"]),
        ("mgeo solve zdt1 --scenario m", ["mine.toml", "more/"]),
        ("mgeo resume ", ["runs/begun"]),
        ("mgeo report ", ["runs/done"]),
        ("mgeo report runs/", ["runs/done"]),
        ("mgeo report nowhere/", []),
        ("mgeo study m", ["mine.toml", "more/"]),
    ],
)
def test_names_files_and_runs_are_offered(mgeo, line, expected):
    for name in ("mine.toml", "more/other.toml", "runs/begun/run.checkpoint", "runs/done/run.json"):
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).touch()
    assert offered(line) == expected


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_the_script_is_shown_and_the_shell_takes_it(mgeo, monkeypatch, tmp_path, shell):
    detected = (shell, f"/bin/{shell}")
    monkeypatch.setattr("shellingham.detect_shell", lambda *arguments, **options: detected)
    monkeypatch.setenv("HOME", str(tmp_path))
    script = mgeo("--show-completion").stdout
    assert "_MGEO_COMPLETE=complete_" + shell in script
    done = mgeo("--install-completion")
    assert done.exit_code == 0, done.output
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert any("_MGEO_COMPLETE" in path.read_text() for path in files)
    if shutil.which(shell):
        subprocess.run([shell, "-n"], input=script, text=True, check=True)


def test_presets_are_declared_where_completion_finds_them():
    pytest.importorskip("mgeo_attitude")
    import tomllib

    from mgeo_attitude.scenario.toml import PRESETS

    project = Path(__file__).parents[3] / "problems" / "attitude" / "pyproject.toml"
    points = tomllib.loads(project.read_text())["project"]["entry-points"]["mgeo.presets"]
    assert points == {
        f"attitude.{name}": f"mgeo_attitude.scenario:Scenario.{name}" for name in PRESETS
    }
