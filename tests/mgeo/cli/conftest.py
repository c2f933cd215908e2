"""The command in an empty folder, with the stand-in plugin installed."""

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app


@pytest.fixture
def mgeo(stand_in, tmp_path, monkeypatch):
    """Runs the command in this process."""
    monkeypatch.chdir(tmp_path)

    def invoke(*arguments):
        return CliRunner().invoke(app, list(map(str, arguments)), prog_name="mgeo")

    return invoke
