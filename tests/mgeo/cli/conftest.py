"""Fixture that runs the command line in an empty folder."""

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app


@pytest.fixture
def mgeo(stand_in, tmp_path, monkeypatch):
    """Return a function that runs ``mgeo`` in this process, with the stand-in plugin installed."""
    monkeypatch.chdir(tmp_path)

    def invoke(*arguments):
        return CliRunner().invoke(app, list(map(str, arguments)), prog_name="mgeo")

    return invoke
