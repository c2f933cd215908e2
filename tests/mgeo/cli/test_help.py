"""Help, and the ways in which commands end."""

import re
import shlex
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
import typer

from mgeo.cli.app import EXAMPLES, app
from mgeo.cli.errors import ExitCode

GROUP = typer.main.get_command(app)


def words(text):
    return " ".join(text.split())


@pytest.mark.parametrize("command", GROUP.commands)
def test_every_command_has_examples_that_can_be_typed(mgeo, command):
    done = mgeo(command, "--help")
    assert done.exit_code == 0
    assert mgeo(command, "-h").stdout == done.stdout
    shown = words(done.stdout.replace(" \\\n", "\n"))  # as a shell reads it
    for example in EXAMPLES[command]:
        assert example in shown
        program, name, *arguments = shlex.split(example.partition("|")[0])
        assert (program, name) == ("mgeo", command)
        with GROUP.commands[command].make_context(command, arguments):
            pass  # raises what the command line would be refused for


def test_every_exit_code_is_in_the_help(mgeo):
    text = words(mgeo("--help").stdout)
    for code in ExitCode:
        assert f"{code.value} {code.meaning}" in text


def test_without_words_there_is_help(mgeo):
    bare = mgeo()
    assert bare.exit_code == 2
    assert "Commands:" in bare.output


def test_version(mgeo):
    project = Path(__file__).parents[3] / "pyproject.toml"
    version = tomllib.loads(project.read_text())["project"]["version"]
    first, *others = mgeo("--version").stdout.splitlines()
    assert first == f"mgeo {version}"
    assert {f"mgeo-attitude {version}", f"numpy {metadata.version('numpy')}"} < {*others}
    assert not any(line.startswith("pytest") for line in others)  # of an extra


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--nonsense"], r"No such option:? '?--nonsense'? \(see mgeo --help\)"),
        (["solv"], r"No such command 'solv'.* \(see mgeo --help\)"),
        (["solve"], r"Missing argument '(?i:problem)' \(see mgeo solve --help\)"),
        (
            ["study", "a", "b"],
            r"Got unexpected extra argument.*b.* \(see mgeo study --help\)",
        ),
    ],
)
def test_usage_errors_are_one_line(mgeo, arguments, message):
    refused = mgeo(*arguments)
    assert (refused.exit_code, refused.stdout) == (2, "")
    assert re.fullmatch(rf"Error: {message}\n", refused.stderr), refused.stderr


def test_an_interrupt_before_a_run_has_begun(mgeo, monkeypatch):
    def impatient(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr("mgeo.cli.installed.installed_plugins", impatient)
    done = mgeo("problems")
    assert (done.exit_code, done.stderr) == (130, "Error: interrupted\n")
