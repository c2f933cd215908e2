"""Commands of ``mgeo attitude``: help texts and JSON output."""

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
def test_examples_of_every_command_are_valid(run, command):
    shown = " ".join(run(command, "--help").stdout.replace(" \\\n", "\n").split())
    for example in EXAMPLES[command]:
        assert example in shown  # Line continuations are joined as by a shell.
        program, group, name, *arguments = shlex.split(re.split("[|>]", example)[0])
        assert (program, group, name) == ("mgeo", "attitude", command)
        with GROUP.commands[command].make_context(command, arguments):
            pass


def test_show_and_export_print_json(run, folder, front, tmp_path):
    plan = front.select_plan("min-trace")
    document = json.loads(run("show", folder, "--pick", "min-trace", "--json").stdout)
    assert (document["t_end_s"], document["trace"]) == (plan.t_end, plan.trace)
    assert len(document["timeline"]) == len(plan.phases)
    assert len(document["least_observable"]) == 5
    file = tmp_path / "plan.json"
    assert json.loads(run("export", folder, file, "--json").stdout) == {"files": [str(file)]}
