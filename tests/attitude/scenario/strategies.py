"""Hypothesis strategies for valid scenarios, with numbers from the declared ranges."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

from hypothesis import strategies as st
from mgeo_attitude import Suite
from mgeo_attitude.criteria.objectives import OBJECTIVES
from mgeo_attitude.environment.constants import EARTH_RADIUS
from mgeo_attitude.scenario import Orbit
from mgeo_attitude.scenario.constraints import ManeuverBounds
from mgeo_attitude.scenario.criteria import Convergence
from mgeo_attitude.scenario.initial_conditions import InitialConditions
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors import SENSORS
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.settings.base import build_schema


def build_settings(cls: type, **fixed: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    """Return a strategy for settings with numbers from their ranges; `fixed` has other fields."""
    numbers = {
        key: _numbers(schema)
        for key, schema in build_schema(cls)["properties"].items()
        if schema.get("type") in ("number", "integer")
    }
    return st.builds(cls, **(numbers | fixed))


@st.composite
def orbits(draw: st.DrawFn) -> Orbit:
    eccentricity = draw(st.floats(0.0, 0.9))
    perigee = draw(st.floats(1.01 * EARTH_RADIUS, 8.0 * EARTH_RADIUS))
    orbit: Orbit = draw(
        build_settings(
            Orbit,
            propagator=st.sampled_from(("two-body", "j2")),
            semi_major_axis=st.just(perigee / (1.0 - eccentricity)),
            eccentricity=st.just(eccentricity),
        )
    )
    return orbit


def initial_conditions() -> st.SearchStrategy[InitialConditions]:
    """Return a strategy for initial conditions with inertial attitudes and attitude laws."""
    axis = st.sampled_from([(0.0, 0.6, -0.8), (1, 0, 0), (0.7071, 0.7071, 0.0)])
    rate = st.none() | st.tuples(*[st.floats(-1e-3, 1e-3)] * 3)
    return st.one_of(
        build_settings(InitialConditions, rate_deg_s=rate),
        build_settings(
            InitialConditions, quaternion=st.just((0.5, -0.5, 0.5, 0.5)), rate_deg_s=rate
        ),
        build_settings(InitialConditions, axes=st.just([(0, 1, 0), (-1, 0, 0), (0, 0, 1)])),
        build_settings(
            InitialConditions,
            pointing=st.sampled_from(("nadir", "velocity", "sun")),
            axis=st.none() | axis,
            clock_deg=st.none() | st.floats(-360.0, 360.0),
            rate_deg_s=rate,
        ),
    )


@st.composite
def scenarios(draw: st.DrawFn) -> Scenario:
    step = draw(st.sampled_from((0.1, 0.25, 1.0, 3.7)) | st.floats(1e-3, 60.0))
    n_steps = draw(st.integers(1, 20_000))
    gyro = draw(build_settings(Gyro))
    names = st.text("abcXYZ019_-", min_size=1, max_size=8).filter(lambda name: name != "gyro")
    sensors = tuple(
        draw(build_settings(draw(st.sampled_from(sorted(SENSORS.items())))[1], name=st.just(name)))
        for name in draw(st.lists(names, min_size=1, max_size=4, unique=True))
    )
    # The attitude keeps its weight, since not all weights may be zero.
    blocks = st.sampled_from(Suite(gyro, sensors).blocks[1:])
    objectives = st.sampled_from(tuple(OBJECTIVES)).filter("t_required".__ne__) | blocks.map(
        "trace:{}".format
    )
    printable = st.characters(exclude_categories=("C", "Z"))
    return Scenario(
        name=draw(st.text(printable, min_size=1)),
        epoch=draw(
            st.datetimes(datetime(1900, 1, 1), datetime(2029, 12, 1), timezones=st.just(UTC))
        ),
        duration=n_steps * step,
        step=step,
        eclipse=draw(st.booleans()),
        objectives=draw(st.lists(objectives, min_size=1, max_size=3, unique=True)),
        orbit=draw(orbits()),
        gyro=gyro,
        sensors=sensors,
        initial=draw(initial_conditions()),
        maneuvers=draw(
            build_settings(
                ManeuverBounds,
                max_rate_deg_s=st.floats(0.0, 100.0 / step, exclude_min=True),
            )
        ),
        convergence=draw(
            build_settings(Convergence, window=st.integers(1, n_steps).map(lambda k: k * step))
        ),
        trace_weights=draw(st.dictionaries(blocks, st.floats(0.0, 1e6))),
    )


def _numbers(schema: dict[str, Any]) -> st.SearchStrategy[Any]:
    low = schema.get("exclusiveMinimum", schema.get("minimum", -1e9))
    high = schema.get("exclusiveMaximum", schema.get("maximum", 1e9))
    if schema["type"] == "integer":
        return st.integers(low, high)
    exclude_min, exclude_max = "exclusiveMinimum" in schema, "exclusiveMaximum" in schema
    return st.floats(low, min(high, 1e9), exclude_min=exclude_min, exclude_max=exclude_max)
