"""Path limits that may be exceeded for some time, against a count along the motion."""

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, filter_history, reference_run
from mgeo_attitude.environment.directions import Place
from mgeo_attitude.filter.path_limits import excess_along
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.plan import ManeuverPlan

LIMITS = {
    "array": {"sense": "keep-in", "half_angle_deg": 60.0, "boresight": [1.0, 0.0, 0.0]},
    "radiator": {"reference": "earth", "half_angle_deg": 40.0, "boresight": [0.0, 1.0, 0.2]},
}
DESIGN = np.array([0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 250.0, 0.2, -0.4, 0.7, 300.0])


def scenario(name, **changed):
    limit = {"name": name, "may_exceed": 120.0} | LIMITS[name] | changed
    return Scenario.from_dict(
        {
            "preset": "cubesat_6u",
            "duration": 1200.0,
            "maneuvers": {"count": 3},
            "convergence": {"rule": "trace"},
            "path_limits": [limit],
        }
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", LIMITS)
def test_the_time_is_that_of_the_steps_in_which_it_is_exceeded(name):
    problem = AttitudeManeuverProblem(scenario(name))
    model, (limit,) = problem.model, problem.scenario.path_limits
    n = round(filter_history(model, DESIGN).t_end / model.step)
    motion = Motion.of(model, DESIGN, n)
    at = Place.at(problem.scenario, model.times[: n + 1])
    turn = np.vstack([np.zeros(3), model.step * motion.rates])
    known = reference_run(model, DESIGN).predicted_attitude[: n + 1]
    excess = excess_along(
        limit.cone(),
        limit.attitude_sigmas,
        at,
        problem.scenario.epoch,
        motion.attitude,
        turn,
        known,
    )
    expected = float(np.count_nonzero(excess[1:] > limit.bound))
    assert 0.0 < expected < n
    G = problem.evaluate(DESIGN, return_values_of=["G"])
    assert G[0] == pytest.approx(expected / 120.0 - 1.0, abs=1e-12)


def test_a_limit_that_may_be_exceeded_long_is_kept_and_a_short_one_is_not():
    rows = [
        ManeuverPlan(scenario("array", may_exceed=time), tuple(DESIGN)).constraints().iloc[0]
        for time in (1.0, 1200.0)
    ]
    assert [row["kept"] for row in rows] == [False, True]
    assert rows[0]["value"] == rows[1]["value"]
    assert rows[0]["unit"] == "s"


def test_one_that_is_exceeded_at_the_start_is_no_reason_to_refuse():
    AttitudeManeuverProblem(scenario("array", boresight=[-1.0, -1.0, 0.0], half_angle_deg=40.0))
