"""Declarations of the JSON documents of ``mgeo attitude verify``, ``fly`` and ``calibrate``."""

from __future__ import annotations

from typing import Any, NotRequired

from mgeo_attitude.documents import ObjectiveRow
from typing_extensions import TypedDict

from mgeo.validation.documents import Document, extensible
from mgeo_calibration.calibration.consistency_tests import Failure, PriorTest, SensorTest
from mgeo_calibration.calibration.model_tests import ModelTest


class PathConstraintRow(TypedDict):
    """Violations of one path constraint in the Monte Carlo runs.

    Steered: a controller keeps the estimated attitude on the planned attitude. Open loop: the
    planned rates are executed exactly.
    """

    path_constraint: str
    """Name of the constraint."""
    steered_runs_percent: float
    """Share of runs with a violation, steered."""
    steered_time_percent: float
    """Share of time in violation, steered."""
    open_loop_runs_percent: float
    """Share of runs with a violation, open loop."""
    open_loop_time_percent: float
    """Share of time in violation, open loop."""


class GuidanceRow(TypedDict):
    """Statistics of one quantity over Monte Carlo runs with gyro-based guidance.

    The controller of these runs follows an attitude that is integrated from the gyro.
    """

    quantity: str
    """Pointing error, constraint, body rate or wheel momentum."""
    unit: str
    """Unit of the values."""
    plan: float
    """Value of the plan without margin, in `unit`."""
    median: float
    """Median of the runs, in `unit`."""
    in_90_percent_of_runs: float
    """Value that 90 % of the runs do not exceed on the unfavorable side, in `unit`."""
    bound_type: str
    """"at most" or "at least"; empty without constraint."""
    bound_value: float | None
    """Bound in `unit`; null without constraint."""
    violated_percent: float | None
    """Share of runs that violate the constraint; null without constraint."""


class VerificationDocument(TypedDict):
    """Result of the verification of a plan by Monte Carlo runs.

    `mgeo report` shows its title, conclusion and table.
    """

    title: str
    """Title of the verification."""
    conclusion: str
    """Verdict and its evidence in a few sentences."""
    is_achieved: bool
    """Whether the plan achieves its predicted accuracy."""
    failures: list[str]
    """Quantities that fail, one sentence each."""
    violations: list[str]
    """Constraints of the scenario that the plan violates."""
    suggestions: list[str]
    """Suggestions, one sentence each."""
    t_end_s: float
    """Convergence time of the plan."""
    n_runs: int
    """Number of Monte Carlo runs."""
    seed: int
    """Seed of the random errors."""
    significance_level: float
    """Probability that the test rejects a valid plan."""
    max_ratio: float
    """Largest ratio of rms error to 1-sigma that a state may have."""
    nees: float
    """Normalized estimation error squared per state; 1 is expected."""
    max_nees: float
    """Largest value of `nees` that passes the test."""
    detectable_ratio: float
    """Smallest ratio of actual error to 1-sigma that this number of runs detects with a probability
    of 90 %."""
    columns: list[str]
    """Titles of the columns of `rows`, with units in brackets."""
    rows: list[list[str | float | None]]
    """One row per state: unit, predicted 1-sigma, rms error, their ratios and p values."""
    solution: int | None
    """Number of the solution in the front of its run, from 0; null for a plan file."""
    summary: str
    """Summary of the plan in one line."""
    problem: str
    """Name of the problem, as in run.json."""
    options: dict[str, Any]
    """Options of the problem, as in run.json."""
    design: list[float]
    """Body rates x, y, z [deg/s] and duration [s] of each maneuver, one after the other."""
    path_constraints: list[PathConstraintRow]
    """Violations of path constraints."""
    gyro_guidance: list[GuidanceRow]
    """Motion with gyro-based guidance; empty for a satellite with magnetorquers."""
    objectives: list[ObjectiveRow]
    """Objectives in Monte Carlo runs."""


class ComparisonRow(TypedDict):
    """True value of one quantity in a simulated run, and its value in the plan."""

    quantity: str
    """Pointing error, constraint, body rate or wheel momentum."""
    unit: str
    """Unit of the values."""
    plan: float
    """Value of the plan without margin, in `unit`."""
    simulated: float
    """Value of the simulated run, in `unit`."""
    bound_type: str
    """"at most" or "at least"; empty without constraint."""
    bound_value: float | None
    """Bound in `unit`; null without constraint."""
    satisfied: bool
    """Whether the simulated value satisfies the constraint."""


class TrueParameter(TypedDict):
    """True value of one calibration parameter about one axis."""

    block: str
    """Gyro or sensor, and parameter, such as "gyro.bias"."""
    axis: str
    """Axis: "x", "y" or "z"."""
    unit: str
    """Unit of the values, such as deg/h, arcmin or nT."""
    value: float
    """True value, in `unit`."""


class TruthFile(TypedDict):
    """True attitude and true calibration parameters at the last sample of a simulated run."""

    format: str
    """Always "mgeo-attitude-truth"."""
    version: int
    """Version of the file format."""
    scenario: dict[str, Any]
    """All keys of the scenario, as in a scenario file."""
    design: list[float]
    """Body rates x, y, z [deg/s] and duration [s] of each maneuver, one after the other."""
    simulator: str
    """Simulator: "kinematic" or "basilisk"."""
    seed: int
    """Seed of the random errors."""
    time_s: float
    """Time of the last sample after the epoch."""
    quaternion: list[float]
    """True attitude: rotation from GCRF to body axes, scalar part last."""
    states: dict[str, list[float]]
    """True states by block, in the units of the filter: rad, rad/s, and magnetic fields divided by
    50,000 nT."""
    parameters: list[TrueParameter]
    """The same states, in the units of calibrations."""


class SimulationDocument(TypedDict):
    """Result of simulating one run of a plan."""

    files: list[str]
    """Paths of the written files."""
    n_samples: int
    """Number of samples of telemetry."""
    comparison: list[ComparisonRow]
    """True motion, compared with the plan."""
    truth: TruthFile
    """Truth at the last sample, as in the file of `--truth`."""


class ParameterRow(TypedDict):
    """Estimate of one calibration parameter about one axis."""

    block: str
    """Gyro or sensor, and parameter, such as "gyro.bias"."""
    axis: str
    """Axis: "x", "y" or "z"."""
    unit: str
    """Unit of the values, such as deg/h, arcmin or nT."""
    estimate: float
    """Estimate, in `unit`."""
    sigma: float
    """1-sigma of the estimate, in `unit`."""
    prior_sigma: float
    """Initial 1-sigma, in `unit`."""
    estimate_si: float
    """Estimate, in `unit_si`."""
    sigma_si: float
    """1-sigma of the estimate, in `unit_si`."""
    prior_sigma_si: float
    """Initial 1-sigma, in `unit_si`."""
    unit_si: str
    """SI unit."""


class RequirementRow(TypedDict):
    """Required 1-sigma of one quantity, and the 1-sigma that the calibration achieved."""

    block: str
    """Gyro or sensor, and parameter, such as "gyro.bias", or "attitude"."""
    unit: str
    """Unit of the values, such as deg/h, arcmin or nT."""
    required: float
    """Required 1-sigma, in `unit`."""
    achieved: float
    """1-sigma of the calibration about the worst axis, in `unit`."""
    satisfied: bool
    """Whether the calibration is consistent and its 1-sigma satisfies the requirement."""


@extensible
class Correction(TypedDict):
    """Parameters that the satellite uses to correct the readings of one gyro or sensor.

    A sensor reports R (I + diag k + N) s + b for a vector s in the body frame. Parameters that the
    scenario does not estimate are left out. If errors depend on housekeeping channels or on the
    rate, their coefficients are further keys.
    """

    dcm: NotRequired[list[list[float]]]
    """Rotation R from body to sensor axes, by rows."""
    quaternion: NotRequired[list[float]]
    """The same rotation as a quaternion, scalar part last."""
    rotation: NotRequired[str]
    """Direction of the rotation: "body-to-sensor"."""
    scale_factor: NotRequired[list[float]]
    """Scale-factor errors k."""
    nonorthogonality: NotRequired[list[float]]
    """Elements yz, zx and xy of the symmetric matrix N."""
    bias: NotRequired[list[float]]
    """Bias b, in `unit`."""
    unit: NotRequired[str]
    """Unit of `bias` and of the readings: deg/s for the gyro, nT for a magnetometer, "-" for Sun
    and horizon sensors, which measure unit vectors."""
    correction: NotRequired[list[list[float]]]
    """Matrix C of the correction s = C (report - b), if k or N is estimated."""
    latency_s: NotRequired[float]
    """Latency of the readings: the time of measurement is the time stamp minus the latency."""
    gain: NotRequired[float]
    """Gain of a photodiode, by which its readings are divided."""
    normal: NotRequired[list[float]]
    """Unit vector of the normal of a photodiode, in body axes."""


class TestRow(TypedDict):
    """Consistency test."""

    test: str
    """Name of the test."""
    statistic: str
    """Test statistic."""
    value: float
    """Value of the statistic."""
    bound_type: str
    """"at most" or "at least"."""
    bound_value: float
    """Bound of the value."""
    is_passed: bool
    """Whether the test is passed."""


class Outlier(TypedDict):
    """Rejected reading."""

    time_s: float
    """Time after the epoch."""
    sensor: str
    """Name of the sensor."""
    chi_square: float
    """Squared innovation, normalized by its covariance."""


class CalibrationFile(TypedDict):
    """Result of a calibration: the verdict and the estimates at the last sample."""

    conclusion: str
    """Verdict in one sentence."""
    is_consistent: bool
    """Whether telemetry and scenario are statistically consistent."""
    failures: list[Failure]
    """Failed tests, the most likely cause first."""
    utc: str
    """Time of the estimates in UTC."""
    attitude_1sigma_deg: float
    """Attitude accuracy, 1-sigma about the worst body axis."""
    requirements: list[RequirementRow]
    """Required 1-sigmas of the scenario; empty without any."""
    parameters: list[ParameterRow]
    """Calibration parameters with their 1-sigma."""
    corrections: dict[str, Correction]
    """Parameters for the onboard software, by the name of the gyro or sensor."""
    tests: list[TestRow]
    """Results of all tests."""
    not_calibrated: dict[str, str]
    """Reason why a parameter or an error is not calibrated, by its name."""
    format: str
    """Always "mgeo-attitude-calibration"."""
    version: int
    """Version of the file format."""
    scenario: dict[str, Any]
    """All keys of the scenario, as in a scenario file."""
    time_s: float
    """Time of the estimates after the epoch."""
    quaternion: list[float]
    """Estimated attitude: rotation from GCRF to body axes, scalar part last."""
    rate_deg_s: list[float]
    """Estimated body rate."""
    states: dict[str, list[float]]
    """Estimated states by block, in the units of the filter: rad, rad/s, and magnetic fields
    divided by 50,000 nT."""
    covariance: list[list[float]]
    """Covariance of the attitude error [rad] and of `states`, in this order and these units."""
    sensor_tests: list[SensorTest]
    """Innovation tests of the sensors."""
    prior_tests: list[PriorTest]
    """Tests of the estimates against their prior."""
    model_tests: list[ModelTest]
    """Tests of errors that the scenario does not model."""
    data_faults: list[str]
    """Faults of the telemetry."""
    notes: list[str]
    """Notes, one sentence each."""
    outliers: list[Outlier]
    """Rejected readings."""


class PredictedRow(TypedDict):
    """Achieved 1-sigma of one state, and the 1-sigma that a plan predicted."""

    state: str
    """State, such as "gyro bias x"."""
    unit: str
    """Unit of the 1-sigmas."""
    predicted: float
    """1-sigma that the plan predicts, in `unit`."""
    achieved: float
    """1-sigma of the calibration, in `unit`."""
    ratio: float
    """Achieved 1-sigma divided by the predicted one."""


class CalibrationOutput(TypedDict):
    """Keys of the output of ``mgeo attitude calibrate`` that calibration.json does not contain."""

    predicted: list[PredictedRow]
    """Comparison with the plan of `--plan`; empty without this option."""
    files: list[str]
    """Paths of the written files."""


class RefusalDocument(TypedDict):
    """Reason why telemetry cannot be calibrated.

    The document is printed with `--all`. The exit code is 2.
    """

    error: str
    """Message."""
    checks: dict[str, list[str]]
    """Findings of each check of the telemetry, by the name of the check."""


DOCUMENTS = {
    "attitude-verify": Document("mgeo attitude verify", (VerificationDocument,)),
    "attitude-fly": Document("mgeo attitude fly", (SimulationDocument,)),
    "attitude-calibrate": Document("mgeo attitude calibrate", (CalibrationFile, CalibrationOutput)),
    "attitude-calibrate-refused": Document(
        "mgeo attitude calibrate --all, if telemetry is refused", (RefusalDocument,)
    ),
    "calibration.json": Document("calibration.json", (CalibrationFile,)),
    "truth.json": Document("truth.json", (TruthFile,)),
}
