"""Shell completion, requested as the scripts of the shells do."""

from importlib import metadata

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app


def complete(line, shell="bash"):
    """Return the completions at the end of a command line."""
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
        ("mgeo resume ", []),  # The shell completes files and folders.
    ],
)
def test_completion_offers_matching_names(mgeo, line, expected):
    assert complete(line) == expected


def test_every_attitude_preset_has_an_entry_point():
    attitude = pytest.importorskip("mgeo_attitude.scenario.toml")
    points = metadata.entry_points(group="mgeo.presets")
    declared = {point.name for point in points if point.name.startswith("attitude.")}
    assert declared == {f"attitude.{name}" for name in attitude.PRESETS}
