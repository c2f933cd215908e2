"""Models that a scenario requires: a gyro always, and the geomagnetic field for some devices."""

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.settings.errors import InvalidValue

LATE = {"preset": "paper", "epoch": "2031-03-21T00:00:00Z", "duration": 600.0}
SHORT = {"convergence": {"window": 60.0}}
TRACKER = {"sensors": [{"kind": "sun-sensor"}, {"kind": "star-tracker"}]}
HORIZON = {"sensors": [{"kind": "two-axis-sun-sensor"}, {"kind": "horizon-sensor"}]}
DIODES = {
    "sensors": [
        {"kind": "photodiode", "name": f"face-{face}", "normal": normal}
        for face, normal in enumerate(np.vstack([np.eye(3), -np.eye(3)]).tolist())
    ]
}
WHEELS = {"inertia": [0.1, 0.1, 0.1], "max_momentum": 0.1}


@pytest.mark.parametrize("gyro", [False, "none", None, []])
def test_scenario_without_gyro_is_rejected(gyro):
    with pytest.raises(
        InvalidValue, match=r"gyro = .*the filter needs a gyro.*docs/how-to/describe-sensors\.md"
    ) as error:
        Scenario.from_dict({"preset": "paper", "gyro": gyro})
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "sensors", [TRACKER, HORIZON, DIODES], ids=["tracker", "horizon", "photodiodes"]
)
def test_sensors_without_field_work_outside_years_of_field_model(sensors):
    """The Sun direction is that of an equinox; the field is that of the last year of the model."""
    scenario = Scenario.from_dict(LATE | SHORT | sensors)
    assert not scenario.needs_field
    problem = AttitudeManeuverProblem(scenario)
    F = problem.evaluate(np.tile([0.3, -0.2, 0.1, 100.0], 3), return_values_of=["F"])
    assert np.isfinite(F).all()
    assert abs(problem.environment.sun[0] - [1.0, 0.0, 0.0]).max() < 0.01
    last = Scenario.from_dict(LATE | SHORT | sensors | {"epoch": "2029-12-31T00:00:00Z"})
    strength = [np.linalg.norm(Environment.from_scenario(s).field) for s in (scenario, last)]
    assert strength[0] == pytest.approx(strength[1], rel=0.3)


@pytest.mark.parametrize(
    "devices",
    [
        {},
        TRACKER | {"wheels": WHEELS | {"residual_dipole": [0.01, 0.0, 0.0]}},
        TRACKER | {"magnetorquers": {"max_dipole": [0.2] * 3, "inertia": [0.01] * 3}},
    ],
    ids=["magnetometer", "dipole", "magnetorquers"],
)
def test_devices_that_require_field_are_rejected_outside_years_of_field_model(devices):
    with pytest.raises(InvalidValue, match=r"epoch = .*IGRF-14.* or a scenario that"):
        Scenario.from_dict(LATE | SHORT | devices)


def test_start_delay_beyond_last_year_of_field_model_is_rejected():
    last = {"preset": "paper", "epoch": "2029-12-31T00:00:00Z", "duration": 600.0} | SHORT
    with pytest.raises(InvalidValue, match=r"duration = 600\.0 s, with the largest start delay"):
        Scenario.from_dict(last | {"monte_carlo": {"start_delay": 86000.0}})
    Scenario.from_dict(last | {"monte_carlo": {"start_delay": 85000.0}})
