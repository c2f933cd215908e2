"""The commands as part of ``mgeo``, as a process, and their help."""

import json
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
def test_every_command_has_examples_that_can_be_typed(run, command):
    shown = " ".join(run(command, "--help").stdout.replace(" \\\n", "\n").split())
    for example in EXAMPLES[command]:
        assert example in shown  # as a shell reads it
        program, group, name, *arguments = shlex.split(re.split("[|>]", example)[0])
        assert (program, group, name) == ("mgeo", "attitude", command)
        with GROUP.commands[command].make_context(command, arguments):
            pass


def test_plans_and_files_as_json(run, folder, front, tmp_path):
    plan = front.select_plan("min-trace")
    found = json.loads(run("show", folder, "--pick", "min-trace", "--json").stdout)
    assert (found["t_end_s"], found["trace"]) == (plan.t_end, plan.trace)
    assert len(found["timeline"]) == len(plan.phases)
    assert len(found["least_observable"]) == 5
    file = tmp_path / "plan.json"
    assert json.loads(run("export", folder, file, "--json").stdout) == {"files": [str(file)]}
