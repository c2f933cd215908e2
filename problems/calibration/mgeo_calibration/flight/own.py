"""Telemetry of simulated runs, with errors drawn from the scenario or from another truth."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.geometry.rotation import rotation_vector
from mgeo_attitude.maneuvers.schedule import build_hold_design
from mgeo_attitude.scenario.initial import InitialConditions
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.readings import count_vectors, to_telemetry
from mgeo_attitude.settings.base import get_fields, require_same
from mgeo_attitude.trajectory.trajectory import Trajectory

from mgeo_calibration.flight.flight import Draws, Flight, draw, fly_run, moved, unsteady
from mgeo_calibration.telemetry.telemetry import Telemetry, Truth

#: Keys in which a truth may differ from the scenario, and keys without effect on a run. Of
#: `initial`, only the attitude uncertainty may differ.
FREE = ("epoch", "eclipse", "orbit", "gyro", "sensors", "world", "initial", "name", "objectives")


def fly(
    scenario: Scenario,
    plan: Any,
    seed: int | np.random.Generator | None = None,
    *,
    truth: Scenario | None = None,
    after: Truth | None = None,
    environment: Environment | None = None,
) -> Telemetry:
    """Simulate one run of a plan up to the end of the scenario.

    True errors are drawn from the scenario, and the rates of the plan are executed exactly from the
    true initial attitude, as in `simulation.simulate`. Magnetorquers produce other rates from
    another attitude. A slew back that the scenario requires starts after the predicted convergence
    time, or after the time until which the plan is held. There are no readings at the start.

    Parameters
    ----------
    scenario : Scenario
    plan : ManeuverPlan or array_like, shape (4 m,)
        Plan, or a design with rates [deg/s] and duration [s] of each maneuver; ``[]`` for none.
    seed : int or Generator, optional
        None draws fresh entropy.
    truth : Scenario, optional
        True scenario, if it differs from `scenario`; see `simulation.simulate`.
    after : Truth, optional
        Truth of an earlier run. The run starts with the attitude and the errors of its last sample.
    environment : Environment, optional
        Precomputed environment of the scenario.

    Returns
    -------
    Telemetry
        Telemetry with its `truth`.

    Raises
    ------
    ValueError
        If the design is invalid, or as in `simulation.simulate`.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import fly
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 900.0})
    >>> design = [0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0]
    >>> telemetry = fly(scenario, design, seed=1)
    >>> len(telemetry.times), {name: values.shape for name, values in telemetry.sensors.items()}
    (901, {'sun': (901, 3), 'mag': (901, 3)})
    """
    environment = environment or Environment.from_scenario(scenario)
    planned = FilterModel.from_scenario(scenario, environment)
    design = commanded(scenario, plan, planned)
    model = planned if truth is None else other_truth(truth, scenario, environment)
    n = model.n_steps
    draws = going_on(model, draw(model, n, np.random.default_rng(seed)), after)
    motion = moved(planned, design, n, draws.errors)
    flight = fly_run(model, motion, draws, surroundings(truth or scenario, scenario, environment))
    mean = flight.readings.gyro + unsteady(planned, design, n, flight.start)
    readings = dataclasses.replace(flight.readings, gyro=mean)
    return sent_down(model, dataclasses.replace(flight, readings=readings))


def going_on(model: FilterModel, draws: Draws, after: Truth | None) -> Draws:
    """Replace the initial errors of a run by the final errors of an earlier run, if given."""
    if after is None:
        return draws
    if after.states.shape[1] != model.suite.n_states:
        raise ValueError(
            f"after: truth of {after.states.shape[1]} states: expected the scenario's "
            f"{model.suite.n_states}"
        )
    errors = after.states[-1].copy()
    errors[:3] = -rotation_vector(after.attitude[-1] @ model.initial_attitude.T)
    return dataclasses.replace(draws, errors=errors)


def commanded(scenario: Scenario, plan: Any, model: FilterModel) -> Floats:
    """Return the design of a plan, including the slew back that the scenario requires."""
    design = np.asarray(getattr(plan, "design", plan), dtype=float)
    design = design if design.size else build_hold_design(model.initial_rate)
    if not scenario.maneuvers.slew_back:
        return design
    held = getattr(plan, "held_until", 0.0)
    t_end = float(evaluate(model, design).t_end[0])
    return Trajectory(scenario, model, design, t_end, held).commanded_design


def sent_down(model: FilterModel, flight: Flight) -> Telemetry:
    """Return the readings of a run as telemetry with its truth."""
    suite, rates = model.suite, np.degrees(flight.readings.gyro)
    states = np.tile(flight.errors, (len(flight.gyro), 1))
    states[:, 3 : suite.n_dynamic] = flight.gyro
    step = suite.gyro.quantization_deg_per_s
    if step is not None:
        rates = step * np.round(rates / step)
    return Telemetry(
        times=model.times,
        gyro_deg_s=np.vstack([np.full(3, np.nan), rates]),
        sensors={
            sensor.name: to_telemetry(sensor, vectors)
            for sensor, vectors in zip(suite.sensors, flight.readings.sensors, strict=True)
        },
        truth=Truth(attitude=flight.motion.attitude @ flight.start, states=states),
        others=model.channels,
        steps={} if step is None else {"gyro": np.full(3, step)},
    )


def other_truth(truth: Scenario, scenario: Scenario, environment: Environment) -> FilterModel:
    """Return the model of a truth that differs from the scenario.

    Parameters
    ----------
    truth : Scenario
    scenario : Scenario
    environment : Environment
        Environment of the scenario.

    Raises
    ------
    ValueError
        With the differing key and both values, or if sensors or states differ.
    """
    require_same("truth", truth, scenario, [key for key in get_fields(Scenario) if key not in FREE])
    start = [key for key in get_fields(InitialConditions) if key != "attitude_deg"]
    require_same("truth.initial", truth.initial, scenario.initial, start)
    real, believed = (one.suite for one in (truth, scenario))
    for what, result, expected in (
        ("sensors", *([sensor.name for sensor in suite.sensors] for suite in (real, believed))),
        ("states", real.blocks, believed.blocks),
        (
            "rotations, by number of their first states,",
            real.rotation_indices,
            believed.rotation_indices,
        ),
        ("readings", *([*map(count_vectors, suite.sensors)] for suite in (real, believed))),
    ):
        if result != expected:
            raise ValueError(f"truth has the {what} {result}: expected the scenario's {expected}")
    return FilterModel.from_scenario(truth, surroundings(truth, scenario, environment))


def surroundings(truth: Scenario, scenario: Scenario, environment: Environment) -> Environment:
    """Return the environment of a truth, without shadow if the truth has no eclipses."""
    if (truth.epoch, truth.orbit) != (scenario.epoch, scenario.orbit):
        environment = Environment.from_scenario(truth)
    return environment if truth.eclipse else environment.without_eclipses()
