"""Help, versions, and error messages for invalid command lines."""

import re
import shlex
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
import typer

from mgeo.cli.app import EXAMPLES, app

GROUP = typer.main.get_command(app)


def join_words(text):
    return " ".join(text.split())


@pytest.mark.parametrize("command", EXAMPLES)
def test_examples_in_the_help_are_valid_command_lines(mgeo, command):
    done = mgeo(command, "--help")
    assert done.exit_code == 0
    assert mgeo(command, "-h").stdout == done.stdout
    for example in EXAMPLES[command]:
        assert example in join_words(done.stdout)
        program, name, *arguments = shlex.split(example.partition("|")[0])
        assert (program, name) == ("mgeo", command)
        with GROUP.commands[command].make_context(command, arguments):
            pass  # An invalid command line raises an exception.


@pytest.mark.parametrize("command", [None, *EXAMPLES])
def test_help_fits_into_a_terminal(mgeo, monkeypatch, command):
    monkeypatch.setenv("COLUMNS", "80")
    text = mgeo(*filter(None, [command]), "--help").stdout
    assert max(map(len, text.splitlines())) <= 80
    assert not re.search(r"[{<]|x>=|\.\.\.$", text.partition("COMMAND [ARGS]...")[2] or text)
    assert "General options:" in text


def test_version_option_lists_packages(mgeo):
    project = Path(__file__).parents[3] / "pyproject.toml"
    version = tomllib.loads(project.read_text())["project"]["version"]
    first, *others = mgeo("--version").stdout.splitlines()
    assert first == f"mgeo {version}"
    assert {f"mgeo-attitude {version}", f"numpy {metadata.version('numpy')}"} < {*others}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--nonsense"], r"No such option:? '?--nonsense'? \(see mgeo --help\)"),
        (["algorithms", "--jso"], r"There is no option --jso; did you mean --json\? \(see .*"),
        (["study", "a.toml", "--seeds", "x"], r"--seeds x: expected an integer \(see .*"),
        (["study", "a.toml", "--seeds", "0"], r"--seeds 0: expected at least 1 \(see .*"),
        (["schema", "nothing"], r"NAME = 'nothing': .*'study\.toml'.*"),
        (["suite", "catalog", "none.toml"], r"none.toml: no such file or directory"),
        (["report", "none"], r"there is no folder none"),
        (["solv"], r"No such command 'solv'.* \(see mgeo --help\)"),
        (["solve"], r"Missing argument '(?i:problem)' \(see mgeo solve --help\)"),
        (["study", "a", "b"], r"Got unexpected extra argument.*b.* \(see mgeo study --help\)"),
        (
            ["algorithms", "mgeo-directid"],
            "there is no algorithm .*; did you mean 'mgeo-directed'.*",
        ),
    ],
)
def test_invalid_input_is_one_line(mgeo, arguments, message):
    result = mgeo(*arguments)
    assert (result.exit_code, result.stdout) == (2, "")
    assert re.fullmatch(rf"Error: {message}\n", result.stderr), result.stderr


def test_closed_pipe_does_not_change_the_exit_code():
    """A reader such as ``head -1`` closes the pipe."""
    command = [sys.executable, "-c", "from mgeo.cli.app import main; main()", "algorithms"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    process.stdout.close()
    assert process.stderr.read() == ""
    assert process.wait(60) == 0
    process.stderr.close()
