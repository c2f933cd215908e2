"""Kinematic simulator: telemetry of a plan whose rates are executed exactly, with random sensor
errors.
"""

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
from mgeo_attitude.scenario.initial_conditions import InitialConditions
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.measurements import count_vectors, to_telemetry
from mgeo_attitude.settings.base import get_fields, require_same
from mgeo_attitude.trajectory.trajectory import Trajectory

from mgeo_calibration.simulators.simulated_run import (
    RandomErrors,
    SimulatedRun,
    compute_design_coning,
    compute_true_motion,
    draw_errors,
    simulate_run,
)
from mgeo_calibration.telemetry.telemetry import Telemetry, Truth

#: Keys in which a true scenario may differ from the assumed scenario, and keys without effect on a
#: run. Only the attitude uncertainty of `initial` may differ.
FREE_KEYS = (
    "epoch",
    "eclipse",
    "orbit",
    "gyro",
    "sensors",
    "environment_errors",
    "initial",
    "name",
    "objectives",
)


def simulate_telemetry(
    scenario: Scenario,
    plan: Any,
    seed: int | np.random.Generator | None = None,
    *,
    truth: Scenario | None = None,
    initial_truth: Truth | None = None,
    environment: Environment | None = None,
) -> Telemetry:
    """Simulate one run of a plan with exact rates and random sensor errors, and return its
    telemetry.

    The run lasts until the end of the scenario. True errors are drawn from the scenario, and the
    rates of the plan are executed exactly from the true initial attitude, as in
    `simulation.simulate`. Magnetorquers produce other rates from another attitude. A slew back that
    the scenario requires starts after the predicted convergence time, or after the time until which
    the last attitude of the plan is held. There are no readings at the start.

    Parameters
    ----------
    scenario : Scenario
    plan : ManeuverPlan or array_like, shape (4 m,)
        Plan, or a design with rates [deg/s] and duration [s] of each maneuver; ``[]`` for none.
    seed : int or Generator, optional
        Equal seeds give identical telemetry. None draws fresh entropy.
    truth : Scenario, optional
        True scenario, if it differs from `scenario`; see `simulation.simulate`.
    initial_truth : Truth, optional
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
    >>> from mgeo_calibration import simulate_telemetry
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 900.0})
    >>> design = [0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0]
    >>> telemetry = simulate_telemetry(scenario, design, seed=1)
    >>> len(telemetry.times), {name: values.shape for name, values in telemetry.sensors.items()}
    (901, {'sun': (901, 3), 'mag': (901, 3)})
    """
    environment = environment or Environment.from_scenario(scenario)
    nominal_model = FilterModel.from_scenario(scenario, environment)
    design = complete_design(scenario, plan, nominal_model)
    model = nominal_model if truth is None else build_true_model(truth, scenario, environment)
    n = model.n_steps
    random_errors = continue_errors(
        model, draw_errors(model, n, np.random.default_rng(seed)), initial_truth
    )
    motion = compute_true_motion(nominal_model, design, n, random_errors.initial_errors)
    simulated_run = simulate_run(
        model,
        motion,
        random_errors,
        build_true_environment(truth or scenario, scenario, environment),
    )
    mean = simulated_run.readings.gyro + compute_design_coning(
        nominal_model, design, n, simulated_run.initial_rotation
    )
    readings = dataclasses.replace(simulated_run.readings, gyro=mean)
    return build_telemetry(model, dataclasses.replace(simulated_run, readings=readings))


def continue_errors(
    model: FilterModel, random_errors: RandomErrors, initial_truth: Truth | None
) -> RandomErrors:
    """Replace the initial errors of a run with the final errors of an earlier run, if there is
    one.
    """
    if initial_truth is None:
        return random_errors
    if initial_truth.states.shape[1] != model.suite.n_states:
        raise ValueError(
            f"initial_truth has {initial_truth.states.shape[1]} states: expected the scenario's "
            f"{model.suite.n_states}"
        )
    errors = initial_truth.states[-1].copy()
    errors[:3] = -rotation_vector(initial_truth.attitude[-1] @ model.initial_attitude.T)
    return dataclasses.replace(random_errors, initial_errors=errors)


def complete_design(scenario: Scenario, plan: Any, model: FilterModel) -> Floats:
    """Return the design of a plan as an array, including the slew back if the scenario requires
    it.
    """
    design = np.asarray(getattr(plan, "design", plan), dtype=float)
    design = design if design.size else build_hold_design(model.initial_rate)
    if not scenario.maneuvers.slew_back:
        return design
    hold_end = getattr(plan, "hold_end", 0.0)
    t_end = float(evaluate(model, design).t_end[0])
    return Trajectory(scenario, model, design, t_end, hold_end).commanded_design


def build_telemetry(model: FilterModel, simulated_run: SimulatedRun) -> Telemetry:
    """Convert a simulated run to telemetry that includes the true states."""
    suite, rates = model.suite, np.degrees(simulated_run.readings.gyro)
    states = np.tile(simulated_run.initial_states, (len(simulated_run.varying_states), 1))
    states[:, 3 : suite.n_dynamic] = simulated_run.varying_states
    step = suite.gyro.quantization_deg_per_s
    if step is not None:
        rates = step * np.round(rates / step)
    return Telemetry(
        times=model.times,
        gyro_deg_s=np.vstack([np.full(3, np.nan), rates]),
        sensors={
            sensor.name: to_telemetry(sensor, vectors)
            for sensor, vectors in zip(suite.sensors, simulated_run.readings.sensors, strict=True)
        },
        truth=Truth(
            attitude=simulated_run.motion.attitude @ simulated_run.initial_rotation, states=states
        ),
        housekeeping=model.channels,
        quantization_steps={} if step is None else {"gyro": np.full(3, step)},
    )


def build_true_model(truth: Scenario, scenario: Scenario, environment: Environment) -> FilterModel:
    """Build the filter model of the true scenario. Raise ValueError if it is incompatible with the
    assumed scenario.

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
    require_same(
        "truth", truth, scenario, [key for key in get_fields(Scenario) if key not in FREE_KEYS]
    )
    start = [key for key in get_fields(InitialConditions) if key != "attitude_deg"]
    require_same("truth.initial", truth.initial, scenario.initial, start)
    true_suite, assumed_suite = truth.suite, scenario.suite
    for what, result, expected in (
        (
            "sensors",
            *([sensor.name for sensor in suite.sensors] for suite in (true_suite, assumed_suite)),
        ),
        ("states", true_suite.blocks, assumed_suite.blocks),
        (
            "rotations, by number of their first states,",
            true_suite.rotation_indices,
            assumed_suite.rotation_indices,
        ),
        (
            "readings",
            *([*map(count_vectors, suite.sensors)] for suite in (true_suite, assumed_suite)),
        ),
    ):
        if result != expected:
            raise ValueError(f"truth has the {what} {result}: expected the scenario's {expected}")
    return FilterModel.from_scenario(truth, build_true_environment(truth, scenario, environment))


def build_true_environment(
    truth: Scenario, scenario: Scenario, environment: Environment
) -> Environment:
    """Return the environment along the true orbit. Eclipses are included only if the true scenario
    has eclipses.
    """
    if (truth.epoch, truth.orbit) != (scenario.epoch, scenario.orbit):
        environment = Environment.from_scenario(truth)
    return environment if truth.eclipse else environment.without_eclipses()
