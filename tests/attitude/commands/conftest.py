"""Fixtures: a run folder, which tests do not modify, and the command in this process."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan, read_front, write_plan
from mgeo_attitude.scenario import Wheels
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.store.run_folder import write_run

from ..small_run import small_run


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    scenario = dataclasses.replace(Scenario.paper(), duration=2400.0, step=4.0)
    path = tmp_path_factory.mktemp("runs") / "one"
    write_run(path, small_run(AttitudeManeuverProblem(scenario)))
    return path


@pytest.fixture(scope="session")
def front(folder):
    return read_front(folder)


@pytest.fixture(scope="session")
def violating(tmp_path_factory):
    """File of a plan whose wheels would need ten times their maximum momentum."""
    wheels = Wheels(inertia=(0.1, 0.1, 0.1), max_momentum=0.1 * np.radians(0.1))
    scenario = dataclasses.replace(Scenario.paper(), duration=600.0, wheels=wheels)
    path = tmp_path_factory.mktemp("plans") / "violating.json"
    write_plan(ManeuverPlan(scenario, (1.0, 0.0, 0.0, 60.0) * 3), path)
    return path


@pytest.fixture
def run():
    """Function that runs ``mgeo attitude`` with arguments and checks the exit code."""

    def invoke(*arguments, code=0):
        done = CliRunner().invoke(app, ["attitude", *map(str, arguments)], prog_name="mgeo")
        assert done.exit_code == code, done.output + done.stderr
        return done

    return invoke
