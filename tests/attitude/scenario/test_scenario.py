"""Consistency checks across the fields of a scenario, and conversion of its fields."""

from __future__ import annotations

import dataclasses
from datetime import UTC, datetime, timedelta, timezone
from typing import Any

import numpy as np
import pytest
from mgeo_attitude import Suite
from mgeo_attitude.scenario import (
    Convergence,
    ManeuverBounds,
    Scenario,
    TLEOrbit,
    TraceWeights,
)
from mgeo_attitude.sensors import Gyro, SunSensor
from mgeo_attitude.settings.errors import InvalidValue

from .test_orbit import ISS_1, ISS_2


def replace_in_paper(**changes: Any) -> Scenario:
    return dataclasses.replace(Scenario.paper(), **changes)


def test_times_are_multiples_of_step() -> None:
    scenario = replace_in_paper(duration=0.9, step=0.1, convergence=Convergence(window=0.3))
    assert scenario.n_steps == 9  # In floating point, 0.9 / 0.1 is not 9.
    np.testing.assert_allclose(scenario.times, np.linspace(0.0, 0.9, 10), rtol=1e-15)
    assert scenario.times.dtype == np.float64
    assert Scenario.paper().times[[0, 1, -1]].tolist() == [0.0, 1.0, 11984.0]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"step": 7.0}, "convergence.window = 300.0: expected a multiple of step = 7.0 s"),
        ({"step": 0.01}, "duration = 11984.0: expected at most 1000000 times step = 0.01 s"),
        (
            {"step": 0.02, "convergence": Convergence(window=2000.02)},
            "convergence.window = 2000.02: expected at most 100000 times step = 0.02 s",
        ),
        (
            {"step": 10.0, "duration": 12000.0, "maneuvers": ManeuverBounds(max_rate_deg_s=30.0)},
            "maneuvers.max_rate_deg_s = 30.0: expected less than 10.39, so that a rotation at "
            "this rate about all axes is less than 180 deg in step = 10.0 s; or a step below 3.464",
        ),
        ({"name": "a\nb"}, "name = 'a\\nb': expected printable characters on one line"),
        ({"sensors": ()}, "sensors = (): expected a list of 1 or more values"),
        (
            {"sensors": (SunSensor(name="gyro"),)},
            "sensors[0].name = 'gyro': expected another name",
        ),
        (
            {"sensors": ({"kind": "sun-sensor", "name": "a.b"},)},
            "sensors[0].name = 'a.b': expected a string that matches ^[A-Z_a-z0-9-]+$",
        ),
        (
            {"trace_weights": {"attitude": -1.0}},
            "trace_weights.attitude = -1.0: expected greater than or equal to 0",
        ),
        ({"sensors": (Gyro(),)}, "sensors[0] = Gyro("),
        (
            {"trace_weights": {"sun.biass": 2.0}},
            "trace_weights.sun.biass = 2.0: unknown state block; did you mean 'sun.bias'? (known: "
            "'attitude', 'gyro.bias', 'sun.misalignment', 'sun.bias', 'mag.misalignment', "
            "'mag.bias')",
        ),
    ],
)
def test_inconsistent_values_are_rejected(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidValue) as error:
        replace_in_paper(**changes)
    assert str(error.value).startswith(message)


def test_epoch_with_offset_is_converted_to_utc() -> None:
    brazil = timezone(timedelta(hours=-3))
    scenario = replace_in_paper(epoch=datetime(2018, 6, 4, 21, tzinfo=brazil))
    assert scenario == Scenario.paper()
    assert scenario.epoch.tzinfo is UTC


def test_element_set_far_from_epoch_is_rejected() -> None:
    orbit = TLEOrbit(line1=ISS_1, line2=ISS_2)
    near = orbit.epoch + timedelta(days=29)
    assert replace_in_paper(orbit=orbit, epoch=near).orbit is orbit
    with pytest.raises(InvalidValue) as error:
        replace_in_paper(orbit=orbit)
    message = str(error.value)
    assert message.startswith(f"orbit.line1 = {ISS_1!r}: expected an element set within 30 days of")
    assert "epoch = 2018-06-05T00:00:00+00:00, not of 2008-09-20T12:25:40" in message


def test_trace_weights_are_one_by_default() -> None:
    scenario = replace_in_paper(trace_weights={"attitude": 2, "mag.bias": 0.0})
    blocks = Suite(scenario.gyro, scenario.sensors).blocks
    weights = scenario.trace_weights
    assert isinstance(weights, TraceWeights)
    assert weights.list_weights(blocks) == (2.0, 1.0, 1.0, 1.0, 1.0, 0.0)
    assert dict(weights) == {"attitude": 2.0, "mag.bias": 0.0}


def test_zero_trace_weights_are_rejected() -> None:
    paper = Scenario.paper()
    blocks = Suite(paper.gyro, paper.sensors).blocks
    with pytest.raises(InvalidValue, match=r"^trace_weights = .*: expected a weight above 0$"):
        replace_in_paper(trace_weights=dict.fromkeys(blocks, 0.0))
