"""Code and commands of the pages of docs/."""

import re
import shlex
from pathlib import Path

from typer.testing import CliRunner

from mgeo.cli.app import app

DOCS = Path(__file__).parents[2] / "docs"


def blocks(name, language):
    """Return the code blocks of a page in a language."""
    text = (DOCS / name).read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def saved_files(name):
    """Return the text of each file that cells ``%%save FILE`` of a page write, by file name."""
    text = (DOCS / name).read_text(encoding="utf-8")
    return dict(re.findall(r"^%%save (\S+)\n(.*?)^```", text, re.DOTALL | re.MULTILINE))


def run(command, *more, codes=(0,)):
    """Run a command line of ``mgeo`` in this process.

    Returns
    -------
    str
        stdout, or stdout and stderr where the command ends with another code than 0.
    """
    program, *arguments = shlex.split(command)
    assert program == "mgeo"
    done = CliRunner().invoke(app, [*arguments, *more], prog_name="mgeo")
    assert done.exit_code in codes, command + done.output + done.stderr
    return done.output if done.exit_code else done.stdout
