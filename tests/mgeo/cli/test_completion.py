"""What shells offer, asked for as their scripts do."""

from importlib import metadata

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
        ("mgeo solve cantilever --scenario ", ["heavy", "light"]),
        ("mgeo resume ", []),  # the shell offers files and folders
    ],
)
def test_names_are_offered(mgeo, line, expected):
    assert offered(line) == expected


def test_presets_are_declared_where_completion_finds_them():
    attitude = pytest.importorskip("mgeo_attitude.scenario.toml")
    points = metadata.entry_points(group="mgeo.presets")
    declared = {point.name for point in points if point.name.startswith("attitude.")}
    assert declared == {f"attitude.{name}" for name in attitude.PRESETS}
