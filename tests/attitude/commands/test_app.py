"""Commands of ``mgeo attitude``: help texts."""

import re
import shlex

import mgeo_attitude.commands.app as planning
import mgeo_calibration.commands.app as calibration
import pytest
import typer

EXAMPLES = {**planning.EXAMPLES, **calibration.EXAMPLES}
GROUP = typer.main.get_command(planning.app)
GROUP.commands |= typer.main.get_command(calibration.app).commands


@pytest.mark.parametrize("command", GROUP.commands)
def test_examples_of_every_command_are_valid(run, command):
    shown = " ".join(run(command, "--help").stdout.replace(" \\\n", "\n").split())
    for example in EXAMPLES[command]:
        assert example in shown  # Line continuations are joined as by a shell.
        program, group, name, *arguments = shlex.split(re.split("[|>]", example)[0])
        assert (program, group, name) == ("mgeo", "attitude", command)
        with GROUP.commands[command].make_context(command, arguments):
            pass
