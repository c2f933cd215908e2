"""The commands on the page docs/validation/basilisk.md run as documented."""

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app

pytest.importorskip(
    "Basilisk", reason='flights by Basilisk: pip install "./problems/calibration[basilisk]"'
)

pytestmark = pytest.mark.basilisk

PAGE = (Path(__file__).parents[4] / "docs" / "validation/basilisk.md").read_text(encoding="utf-8")


def test_documented_commands_run_from_front_to_calibration(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (commands,) = re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)
    for line in commands.splitlines():
        done = CliRunner().invoke(app, shlex.split(line)[1:], prog_name="mgeo")
        assert done.exit_code == 0, line + done.output + done.stderr
    assert Path("truth.json").is_file()
    assert Path("calibration/calibration.html").is_file()
