"""Commands and suggestions without the package mgeo-calibration."""

import pytest
from mgeo_attitude.calibration_package import COMMANDS, INSTALL_COMMAND

from mgeo.cli import app as cli_app
from mgeo.plugins.discovery import COMMANDS as GROUP
from mgeo.plugins.discovery import list_plugins


@pytest.fixture(autouse=True)
def without_calibration(monkeypatch):
    """Hide the package as if it were not installed."""
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    plugins = [each for each in list_plugins(GROUP) if each.name != "attitude.calibration"]
    monkeypatch.setattr(cli_app, "list_plugins", lambda group: plugins)


@pytest.mark.parametrize("arguments", [("runs/a", "--json"), ("--help",), ()])
@pytest.mark.parametrize("command", COMMANDS)
def test_missing_command_says_how_to_install_it(run, command, arguments):
    message = run(command, *arguments, code=2).stderr
    assert f"mgeo attitude {command}" in message
    assert INSTALL_COMMAND in message
    assert message.count("\n") == 1


def test_help_lists_installed_commands_only(run):
    listed = {line.split()[0] for line in run("--help").stdout.splitlines() if line.strip()}
    assert "export" in listed
    assert listed.isdisjoint(COMMANDS)


def test_missing_command_is_not_suggested(run, front, folder, tmp_path):
    text = run("export", folder, tmp_path / "plan.json").stdout
    suggested = " ".join(
        [text, *front.select_plan("knee").view.next_commands(str(folder)).values()]
    )
    assert suggested.count(INSTALL_COMMAND) == 2
    assert not any(f"mgeo attitude {command}" in suggested for command in COMMANDS)
