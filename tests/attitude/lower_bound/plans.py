"""Scenarios and random plans for tests of the lower bound."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from mgeo_attitude import FilterModel, Scenario, evaluate
from mgeo_attitude.criteria.objectives import OBJECTIVES
from mgeo_attitude.lower_bound.curves import LowerBound
from mgeo_attitude.scenario.prior import Prior
from mgeo_attitude.scenario.toml import PRESETS
from numpy.typing import NDArray

SCENARIOS = Path(__file__).parents[3] / "docs" / "scenarios"
#: Calibrated sensors, with which only attitude and gyro errors remain.
CALIBRATED = (
    {"kind": "sun-sensor", "initial_misalignment_deg": 1e-4, "initial_bias": 1e-6},
    {"kind": "magnetometer", "initial_misalignment_deg": 1e-4, "initial_bias_nt": 0.01},
)
RATE_DEPENDENT_GYRO = {
    "initial_scale_factor": 0.01,
    "initial_misalignment_deg": 1.0,
    "initial_nonorthogonality_deg": 1.0,
    "initial_bias_deg_s": 1e-9,
    "rate_random_walk": 0.0,
    "angle_random_walk_deg_per_sqrt_h": 1e-3,
}
ANISOTROPIC_GYRO = {
    "angle_random_walk_deg_per_sqrt_h": [0.01, 0.1, 1.0],
    "rate_random_walk": [1e-8, 1e-7, 1e-6],
}


def load_documented_scenarios() -> dict[str, Scenario]:
    """Return all presets and all scenario files of the documentation, with a step of 20 s."""
    names = [*PRESETS, *(path.name for path in sorted(SCENARIOS.glob("*.toml")))]
    names.remove("suite.toml")  # This file belongs to the suite plugin.
    scenarios = {}
    for name in names:
        is_file = name.endswith(".toml")
        scenario = (
            Scenario.from_toml(SCENARIOS / name)
            if is_file
            else Scenario.from_dict({"preset": name})
        )
        scenarios[name] = coarsen_scenario(scenario, 20.0)
    return scenarios


def coarsen_scenario(scenario: Scenario, step: float) -> Scenario:
    """Return the scenario with another step, in which each sensor measures in every step."""
    sensors = tuple(dataclasses.replace(each, sample_interval=None) for each in scenario.sensors)
    duration = scenario.duration // step * step
    magnetorquers = scenario.magnetorquers  # A dipole is constant during a step.
    if magnetorquers is not None:
        magnetorquers = dataclasses.replace(
            magnetorquers, time_constant=max(magnetorquers.time_constant, 2.0 * step)
        )
    return dataclasses.replace(
        scenario, step=step, duration=duration, sensors=sensors, magnetorquers=magnetorquers
    )


def build_hard_scenarios() -> dict[str, Scenario]:
    """Return scenarios that are close to a part of the bound or unfavorable for its proof."""

    def build(**keys: object) -> Scenario:
        base = {"preset": "cubesat_6u", "step": 20.0, "duration": 8000.0}
        return Scenario.from_dict(base | keys)

    sun, mag = {"kind": "sun-sensor"}, {"kind": "magnetometer"}
    tracker = {"kind": "star-tracker", "boresight": [1.0, 1.0, 1.0]}
    scenarios = {
        "calibrated": build(sensors=CALIBRATED),
        "constant bias": build(
            sensors=CALIBRATED, gyro={"rate_random_walk": 0.0, "bias_decay": 0.0}
        ),
        "fading bias": build(
            sensors=CALIBRATED, gyro={"rate_random_walk": 1e-6, "bias_decay": 1e-2}
        ),
        "rate-dependent gyro": build(sensors=CALIBRATED, gyro=RATE_DEPENDENT_GYRO),
        "gyro noise by axis": build(sensors=CALIBRATED, gyro=ANISOTROPIC_GYRO),
        "known attitude": build(sensors=CALIBRATED, initial={"attitude_deg": 1e-3}),
        "tracker": build(sensors=[tracker, mag]),
        "considered": build(
            sensors=[sun | {"considered": ["bias"]}, mag], gyro={"considered": ["bias"]}
        ),
        "seldom": build(
            sensors=[sun | {"sample_interval": 100.0}, mag | {"sample_interval": 40.0}]
        ),
        "views": build(sensors=[sun | {"half_angle_deg": 70.0}, mag]),
        "suite": build(duration=900.0),
    }
    continued = {
        f"{name}, after": add_prior(scenarios[name], 5) for name in ("calibrated", "considered")
    }
    return scenarios | continued


def add_prior(scenario: Scenario, seed: int) -> Scenario:
    """Return the scenario after a calibration, with random correlations."""
    rng = np.random.default_rng(seed)
    sigma = FilterModel.from_scenario(scenario).initial_sigma
    n = len(sigma)
    factor = rng.standard_normal((n, n))
    matrix = factor @ factor.T / n + 0.05 * np.eye(n)
    scale = sigma * np.exp(rng.standard_normal(n)) / np.sqrt(np.diag(matrix))
    covariance = np.outer(scale, scale) * matrix
    quaternion = rng.standard_normal(4)
    prior = Prior(
        quaternion=tuple((quaternion / np.linalg.norm(quaternion)).tolist()),
        rate_deg_s=(0.1, 0.2, -0.3),
        states=((0.0, 0.0, 0.0),) * (n // 3 - 1),
        covariance=tuple(map(tuple, (0.5 * (covariance + covariance.T)).tolist())),
    )
    return dataclasses.replace(scenario, prior=prior)


def iterate_random_plans(
    scenario: Scenario, rng: np.random.Generator, n: int
) -> Iterator[NDArray[np.float64]]:
    """Yield `n` random plans in total with 1 to 12 maneuvers, some slow and some at full rate."""
    limits = scenario.maneuvers
    for count in range(1, 13):
        rates = rng.uniform(-1.0, 1.0, (n // 12, count, 3)) * limits.max_rate_deg_s
        rates[::4] *= 0.02
        rates[1::4] = limits.max_rate_deg_s * np.sign(rates[1::4])
        longest = limits.max_duration * rng.uniform(0.0, 1.0, (n // 12, 1))
        durations = longest * rng.uniform(0.0, 1.0, (n // 12, count))
        yield np.concatenate([rates, durations[:, :, None]], axis=2).reshape(n // 12, -1)


def compute_least_ratios(
    model: FilterModel, bound: LowerBound, plans: NDArray[np.float64]
) -> dict[str, float]:
    """Return the smallest ratio of each quantity of the plans to its lower bound."""
    complete = evaluate(model.full_duration_model, plans, 1, history=True)
    variances = complete.variances[:, 1:]
    blocks = variances.reshape(*variances.shape[:2], -1, 3)
    ratios = {"trace": (variances @ model.weights / bound.trace[1:]).min()}
    for i, name in enumerate(model.suite.blocks):
        ratios[name] = (blocks[:, :, i].sum(axis=2) / bound.variance_sum[name][1:]).min()
        max_variance = blocks[:, :, i].max(axis=2) / bound.max_variance[name][1:]
        ratios[f"{name}, worst axis"] = max_variance.min()
    result = evaluate(model, plans, 1, covariance=True)
    end_steps = np.rint(result.t_end / model.step).astype(int)
    ratios["ending"] = (result.trace / bound.trace_at_end[end_steps]).min()
    for name, curve in bound.criteria.items():
        value = OBJECTIVES[name].value(model, result)
        if name == "log_det":  # The value is a logarithm per state.
            ratios[name] = (10.0 ** (value - curve[end_steps])).min()
        else:
            ratios[name] = (value / curve[end_steps]).min()
    return {name: float(ratio) for name, ratio in ratios.items()}


def remove_albedo(scenario: Scenario) -> Scenario:
    """Return the scenario without albedo."""
    sensors = tuple(
        dataclasses.replace(each, includes_albedo=False)
        if hasattr(each, "includes_albedo")
        else each
        for each in scenario.sensors
    )
    world = dataclasses.replace(scenario.environment_errors, albedo=0.0, earth_albedo=0.0)
    return dataclasses.replace(scenario, sensors=sensors, environment_errors=world)
