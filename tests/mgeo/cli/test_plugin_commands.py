"""Commands of plugins, which are imported only when they are run."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.usefixtures("stand_in")


@pytest.fixture
def beam(tmp_path):
    path = tmp_path / "beam.toml"
    path.write_text("0.5")
    return path


def test_help_lists_plugin_commands_without_importing_them(mgeo, monkeypatch):
    monkeypatch.delitem(sys.modules, "stand_in_commands", raising=False)
    listed = [" ".join(line.split()) for line in mgeo("--help").stdout.splitlines()]
    assert any(line.startswith("beam A plugin for the tests") for line in listed)
    assert sum(line.startswith("solve ") for line in listed) == 1
    assert "beam.more" not in " ".join(listed)
    assert "stand_in_commands" not in sys.modules


def test_plugin_command_prints_text_or_json(mgeo, beam):
    assert mgeo("beam", "weigh", beam).stdout == f"{beam}: 3900 kg\n"
    document = json.loads(mgeo("beam", "weigh", beam, "--json").stdout)
    assert document == {"mass_kg": 3900.0, "volume_ratio": 2.0}


def test_another_distribution_extends_plugin_commands(mgeo):
    assert mgeo("beam", "paint", "red").stdout == "red, red\n"
    assert "  cut    Cut it.\n" in mgeo("beam", "--help").stdout


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["weigh", "nowhere.toml"], 2, r"nowhere.toml: no such file or directory"),
        (["weigh"], 2, r"Missing argument '(?i:file)' \(see mgeo beam weigh --help\)"),
        (["wei"], 2, r"No such command 'wei'.* \(see mgeo beam --help\)"),
        (["--nope"], 2, r"No such option:? '?--nope'? \(see mgeo beam --help\)"),
        (["weigh", "nothing.toml"], 1, r"ZeroDivisionError: .* \(stand_in_commands.py, line .*\)"),
    ],
)
def test_error_of_plugin_command_is_one_line_with_an_exit_code(mgeo, arguments, code, message):
    Path("nothing.toml").write_text("0")
    done = mgeo("beam", *arguments)
    assert done.exit_code == code
    assert re.fullmatch(rf"Error: {message}\n", done.stderr), done.stderr


def test_broken_plugin_command_reports_its_error_and_hides_no_other(mgeo):
    assert "  broken " in mgeo("--help").stdout
    done = mgeo("broken", "--help")
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.startswith(
        "Error: command 'broken' of stand-in 1.2.3 cannot be imported: Module"
    )


def test_help_does_not_import_numpy():
    pytest.importorskip("mgeo_attitude")
    code = """
import sys
from mgeo.cli.app import main
sys.argv = ["mgeo", "attitude", "--help"]
try:
    main()
except SystemExit as end:
    print(end.code, "numpy" in sys.modules, file=sys.stderr)
"""
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    assert done.stderr == "0 False\n"
    assert "attitude" in done.stdout
