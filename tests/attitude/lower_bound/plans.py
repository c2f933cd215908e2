"""Random plans held against the limit."""

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
#: Instruments that know themselves: what is left to learn are attitude and gyro.
CALIBRATED = (
    {"kind": "sun-sensor", "initial_misalignment_deg": 1e-4, "initial_bias": 1e-6},
    {"kind": "magnetometer", "initial_misalignment_deg": 1e-4, "initial_bias_nt": 0.01},
)
TURNING = {
    "initial_scale_factor": 0.01,
    "initial_misalignment_deg": 1.0,
    "initial_nonorthogonality_deg": 1.0,
    "initial_bias_deg_s": 1e-9,
    "rate_random_walk": 0.0,
    "angle_random_walk_deg_per_sqrt_h": 1e-3,
}
UNEVEN = {
    "angle_random_walk_deg_per_sqrt_h": [0.01, 0.1, 1.0],
    "rate_random_walk": [1e-8, 1e-7, 1e-6],
}


def documented() -> dict[str, Scenario]:
    """Every preset, and every scenario file of the documentation, at a step of 20 s."""
    names = [*PRESETS, *(path.name for path in sorted(SCENARIOS.glob("*.toml")))]
    names.remove("suite.toml")  # of the suite plugin, whose scenario is in `hard`
    found = {}
    for name in names:
        is_file = name.endswith(".toml")
        scenario = (
            Scenario.from_toml(SCENARIOS / name)
            if is_file
            else Scenario.from_dict({"preset": name})
        )
        found[name] = coarse(scenario, 20.0)
    return found


def coarse(scenario: Scenario, step: float) -> Scenario:
    """The same at another step, with a sample in each."""
    sensors = tuple(dataclasses.replace(each, sample_interval=None) for each in scenario.sensors)
    duration = scenario.duration // step * step
    coils = scenario.magnetorquers  # a dipole is held for a step
    if coils is not None:
        coils = dataclasses.replace(coils, time_constant=max(coils.time_constant, 2.0 * step))
    return dataclasses.replace(
        scenario, step=step, duration=duration, sensors=sensors, magnetorquers=coils
    )


def hard() -> dict[str, Scenario]:
    """Scenarios that come near to each part of the limit, or break what its proof likes."""

    def of(**keys: object) -> Scenario:
        base = {"preset": "cubesat_6u", "step": 20.0, "duration": 8000.0}
        return Scenario.from_dict(base | keys)

    sun, mag = {"kind": "sun-sensor"}, {"kind": "magnetometer"}
    tracker = {"kind": "star-tracker", "boresight": [1.0, 1.0, 1.0]}
    plain = {
        "calibrated": of(sensors=CALIBRATED),
        "constant bias": of(sensors=CALIBRATED, gyro={"rate_random_walk": 0.0, "bias_decay": 0.0}),
        "fading bias": of(sensors=CALIBRATED, gyro={"rate_random_walk": 1e-6, "bias_decay": 1e-2}),
        "gyro that turns": of(sensors=CALIBRATED, gyro=TURNING),
        "gyro noise by axis": of(sensors=CALIBRATED, gyro=UNEVEN),
        "known attitude": of(sensors=CALIBRATED, initial={"attitude_deg": 1e-3}),
        "tracker": of(sensors=[tracker, mag]),
        "considered": of(
            sensors=[sun | {"considered": ["bias"]}, mag], gyro={"considered": ["bias"]}
        ),
        "seldom": of(sensors=[sun | {"sample_interval": 100.0}, mag | {"sample_interval": 40.0}]),
        "views": of(sensors=[sun | {"half_angle_deg": 70.0}, mag]),
        "suite": of(duration=900.0),
    }
    after = {f"{name}, after": with_prior(plain[name], 5) for name in ("calibrated", "considered")}
    return plain | after


def with_prior(scenario: Scenario, seed: int) -> Scenario:
    """It goes on from what a calibration might have left, with correlations."""
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


def random_plans(
    scenario: Scenario, rng: np.random.Generator, n: int
) -> Iterator[NDArray[np.float64]]:
    """In all `n` plans, of each number of maneuvers from 1 to 12; some slow, some at full rate."""
    limits = scenario.maneuvers
    for count in range(1, 13):
        rates = rng.uniform(-1.0, 1.0, (n // 12, count, 3)) * limits.max_rate_deg_s
        rates[::4] *= 0.02
        rates[1::4] = limits.max_rate_deg_s * np.sign(rates[1::4])
        longest = limits.max_duration * rng.uniform(0.0, 1.0, (n // 12, 1))
        durations = longest * rng.uniform(0.0, 1.0, (n // 12, count))
        yield np.concatenate([rates, durations[:, :, None]], axis=2).reshape(n // 12, -1)


def least_ratios(
    model: FilterModel, found: LowerBound, plans: NDArray[np.float64]
) -> dict[str, float]:
    """The least that plans reach over the limit, at all times but the start."""
    ran = evaluate(model.full_duration_model, plans, 1, history=True)
    variances = ran.variances[:, 1:]
    blocks = variances.reshape(*variances.shape[:2], -1, 3)
    ratios = {"trace": (variances @ model.weights / found.trace[1:]).min()}
    for i, name in enumerate(model.suite.blocks):
        ratios[name] = (blocks[:, :, i].sum(axis=2) / found.variance_sum[name][1:]).min()
        worst = blocks[:, :, i].max(axis=2) / found.max_variance[name][1:]
        ratios[f"{name}, worst axis"] = worst.min()
    ended = evaluate(model, plans, 1, covariance=True)
    at = np.rint(ended.t_end / model.step).astype(int)
    ratios["ending"] = (ended.trace / found.trace_at_end[at]).min()
    for name, curve in found.criteria.items():
        value = OBJECTIVES[name].value(model, ended)
        if name == "log_det":  # a logarithm, per state
            ratios[name] = (10.0 ** (value - curve[at])).min()
        else:
            ratios[name] = (value / curve[at]).min()
    return {name: float(ratio) for name, ratio in ratios.items()}


def without_albedo(scenario: Scenario) -> Scenario:
    """The same without light from the Earth."""
    sensors = tuple(
        dataclasses.replace(each, includes_albedo=False)
        if hasattr(each, "includes_albedo")
        else each
        for each in scenario.sensors
    )
    world = dataclasses.replace(scenario.environment_errors, albedo=0.0, earth_albedo=0.0)
    return dataclasses.replace(scenario, sensors=sensors, environment_errors=world)
