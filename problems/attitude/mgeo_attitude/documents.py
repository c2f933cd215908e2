"""Declarations of the JSON documents of ``mgeo attitude`` and of plan files."""

from __future__ import annotations

from typing import Any, NotRequired

from typing_extensions import TypedDict

from mgeo.validation.documents import Document, extensible


class PlanSummary(TypedDict):
    """Summary of a plan."""

    solution: int | None
    """Number of the solution in the front of its run, from 0; null for a plan file."""
    scenario: str
    """Name of the scenario."""
    design: list[float]
    """Body rates x, y, z [deg/s] and duration [s] of each maneuver, one after the other."""
    converged: bool
    """Whether the convergence rule of the scenario is satisfied at `t_end_s`."""
    t_end_s: float
    """Convergence time: time at which the calibration ends, after the epoch."""
    t_end_90_percent_of_runs_s: float | None
    """Convergence time that 90 % of Monte Carlo runs do not exceed; null if fewer converge."""
    hold_end_s: float
    """Time until which the rates of the last maneuver are held."""
    duration_s: float
    """End of the last command, which includes a slew back to the initial attitude."""
    trace: float
    """Trace of the scaled covariance at `t_end_s`, the second objective."""
    attitude_1sigma_deg: float
    """Predicted attitude accuracy, 1-sigma about the worst body axis."""
    attitude_1sigma_any_axis_deg: float
    """Predicted attitude accuracy, 1-sigma about the worst of all axes."""
    attitude_1sigma_90_percent_of_runs_deg: float | None
    """Attitude accuracy that 90 % of Monte Carlo runs reach."""
    attitude_lower_bound_deg: float | None
    """Lower bound of the attitude accuracy for any maneuver of this duration; null if none is
    known."""
    constraints_satisfied: bool
    """Whether the plan satisfies all constraints of its scenario."""
    uncalibrated_errors: list[str]
    """Errors that the plan does not reduce."""
    warnings: list[str]
    """Warnings, each with what to do."""


class Constraint(TypedDict):
    """Constraint of the scenario in a plan file."""

    constraint: str
    """Name of the constraint."""
    unit: str
    """Unit of value and bound."""
    value: float | None
    """Value of the constrained quantity."""
    bound_type: str
    """"at most" or "at least"."""
    bound_value: float | None
    """Bound of the value."""
    satisfied: bool
    """Whether the constraint is satisfied."""


class ConstraintOfPlan(Constraint):
    """Constraint of the scenario, with the part of the plan in which it applies."""

    during: str
    """Part of the plan: "maneuvers", "hold", or another interval after convergence."""
    margin: float | None
    """Distance from the bound, negative if the constraint is violated."""


class ManeuverRow(TypedDict):
    """Maneuver, constant-rate hold or slew back of a plan."""

    maneuver: str
    """Number of the maneuver, "hold" or "slew back"."""
    start_s: float
    """Start after the epoch."""
    duration_s: float
    """Duration."""
    rate_x_deg_s: float
    """Commanded body rate about x."""
    rate_y_deg_s: float
    """Commanded body rate about y."""
    rate_z_deg_s: float
    """Commanded body rate about z."""
    angle_deg: float
    """Accumulated rotation."""
    most_reduced: str
    """Quantity whose 1-sigma the maneuver divides by the largest factor."""
    factor: float | None
    """This factor: 1-sigma before the maneuver, divided by 1-sigma after it."""
    start_utc: str
    """Start in UTC."""


@extensible
class AccuracyRow(TypedDict):
    """Predicted accuracy of one quantity, 1-sigma about the worst body axis.

    Where a lower bound is known, `lower_bound` and `ratio`, the predicted value divided by the
    lower bound, are further keys.
    """

    quantity: str
    """Quantity, such as "attitude" or "gyro bias"."""
    unit: str
    """Unit of the 1-sigmas."""
    before: float
    """1-sigma before the plan, in `unit`."""
    predicted: float
    """Predicted 1-sigma, in `unit`."""
    in_90_percent_of_runs: float | None
    """1-sigma that 90 % of Monte Carlo runs do not exceed, in `unit`."""


class DriverRow(TypedDict):
    """Error source with a large share in the variance of a quantity."""

    quantity: str
    """Quantity, such as "attitude"."""
    unit: str
    """Unit of the 1-sigmas."""
    error_source: str
    """Error source, such as "gyro noise"."""
    share_percent: float
    """Share of the error source in the variance."""
    predicted: float
    """Predicted 1-sigma, in `unit`."""
    if_halved: float | None
    """1-sigma that the same maneuvers give with half of the error source, in `unit`."""


class AxesRow(TypedDict):
    """Accuracy of one quantity about each body axis."""

    quantity: str
    """Quantity, such as "attitude"."""
    unit: str
    """Unit of the 1-sigmas."""
    before_x: float
    """1-sigma about x before the plan, in `unit`; `before_y` and `before_z` likewise."""
    before_y: float
    """1-sigma about y before the plan, in `unit`."""
    before_z: float
    """1-sigma about z before the plan, in `unit`."""
    after_x: float
    """Predicted 1-sigma about x, in `unit`."""
    after_y: float
    """Predicted 1-sigma about y, in `unit`."""
    after_z: float
    """Predicted 1-sigma about z, in `unit`."""


@extensible
class BudgetRow(TypedDict):
    """Contribution of one error source to the 1-sigma of each quantity.

    Further keys are the quantities with their unit, such as `attitude_deg` and `gyro_bias_deg_h`.
    """

    source: str
    """Error source, or "all" for the root sum square of all sources."""


@extensible
class ImprovementRow(TypedDict):
    """Accuracy after one change of the satellite or of the plan.

    Further keys are the quantities with their unit, as in `budget`.
    """

    change: str
    """Change, such as a halved error source; "unchanged" in the first row."""


@extensible
class ReductionRow(TypedDict):
    """Uncertainty at the end of one maneuver, ramp or hold.

    Further keys are the 1-sigmas with their unit, such as `attitude_x_deg`.
    """

    maneuver: str
    """Name of the maneuver, ramp or hold; "start" in the first row."""
    time_s: float
    """End after the epoch."""
    trace: float
    """Trace of the scaled covariance."""
    contribution_percent: float
    """Contribution to the total decrease of the logarithm of the trace."""


@extensible
class DirectionRow(TypedDict):
    """Combination of errors that the plan reduces least.

    Further keys are the 1-sigmas along this direction with their unit, as in `budget`.
    """

    direction: str
    """Combination of errors, described by axes in the body frame."""
    remaining: float
    """Ratio of the final to the initial 1-sigma. Process noise may raise it above 1."""


@extensible
class MeasurementRow(TypedDict):
    """Measurement time of each sensor in one maneuver, ramp or hold.

    Further keys are the sensors, such as `sun_s`: the time [s] during which the sensor provides
    measurements.
    """

    maneuver: str
    """Name of the maneuver, ramp or hold."""
    duration_s: float
    """Duration."""


@extensible
class ComparisonRow(TypedDict):
    """Accuracy that simple maneuvers reach by the convergence time of the plan.

    Further keys are the 1-sigmas with their unit, such as `attitude_1sigma_deg`.
    """

    maneuvers: str
    """Name of the maneuvers; "plan" in the first row."""
    t_end_s: float | None
    """Convergence time of these maneuvers; null if they do not converge."""
    trace_at_t_end: float | None
    """Trace at their own convergence time."""
    trace: float
    """Trace after the convergence time of the plan."""
    trace_ratio: float
    """This trace divided by the trace of the plan."""


class BoundRow(TypedDict):
    """Predicted objective and its lower bound."""

    quantity: str
    """Objective, with its unit in brackets."""
    predicted: float
    """Predicted value."""
    lower_bound: float
    """Lower bound for any maneuver of this duration."""
    ratio: float
    """Predicted value divided by the lower bound."""


class ObjectiveRow(TypedDict):
    """Predicted objective compared with Monte Carlo runs."""

    objective: str
    """Objective, with its unit in brackets."""
    predicted: float
    """Predicted value."""
    in_90_percent_of_runs: float | None
    """Value that 90 % of Monte Carlo runs do not exceed."""
    ratio: float | None
    """This value divided by the predicted value."""


class AttitudeRow(TypedDict):
    """Commanded attitude at the start and the end of one phase.

    Quaternions rotate from GCRF to body axes, with the scalar part last.
    """

    phase: str
    """Name of the phase."""
    start_s: float
    """Start after the epoch."""
    end_s: float
    """End after the epoch."""
    duration_s: float
    """Duration."""
    start_utc: str
    """Start in UTC."""
    end_utc: str
    """End in UTC."""
    rate_x_deg_s: float
    """Commanded body rate about x."""
    rate_y_deg_s: float
    """Commanded body rate about y."""
    rate_z_deg_s: float
    """Commanded body rate about z."""
    rotation_deg: float
    """Accumulated rotation."""
    start_q1: float
    """Quaternion at the start, part 1."""
    start_q2: float
    """Quaternion at the start, part 2."""
    start_q3: float
    """Quaternion at the start, part 3."""
    start_qc: float
    """Quaternion at the start, scalar part."""
    end_q1: float
    """Quaternion at the end, part 1."""
    end_q2: float
    """Quaternion at the end, part 2."""
    end_q3: float
    """Quaternion at the end, part 3."""
    end_qc: float
    """Quaternion at the end, scalar part."""


class Fact(TypedDict):
    """Property of the satellite or its orbit."""

    topic: str
    """Topic, such as "orbit"."""
    description: str
    """Description."""


class Instrument(TypedDict):
    """Gyro or sensor."""

    instrument: str
    """Name."""
    kind: str
    """Kind, such as "magnetometer"."""
    noise: str
    """Noise, with unit."""
    every_s: str
    """Sample interval."""
    errors_at_the_start_1sigma: str
    """Initial errors, 1-sigma, with units."""


class PlanDocument(TypedDict):
    """Sections about a plan, of which `--section` selects some."""

    summary: NotRequired[PlanSummary]
    """Summary."""
    constraints: NotRequired[list[ConstraintOfPlan]]
    """Constraints of the scenario."""
    timeline: NotRequired[list[ManeuverRow]]
    """Maneuvers in the order of their execution."""
    accuracy: NotRequired[list[AccuracyRow]]
    """Predicted accuracy."""
    drivers: NotRequired[list[DriverRow]]
    """Largest error sources of each 1-sigma that the scenario constrains, or of the attitude."""
    axes: NotRequired[list[AxesRow]]
    """Accuracy about each body axis."""
    budget: NotRequired[list[BudgetRow]]
    """Error budget."""
    improvements: NotRequired[list[ImprovementRow]]
    """Accuracy after possible improvements."""
    reduction: NotRequired[list[ReductionRow]]
    """Uncertainty reduction by maneuver."""
    directions: NotRequired[list[DirectionRow]]
    """Least observable directions."""
    measurements: NotRequired[list[MeasurementRow]]
    """Measurement times."""
    comparison: NotRequired[list[ComparisonRow]]
    """Comparison with simple maneuvers."""
    bound: NotRequired[list[BoundRow]]
    """Lower bound of the trace; empty if none is known."""
    objectives: NotRequired[list[ObjectiveRow]]
    """Objectives in Monte Carlo runs."""
    attitudes: NotRequired[list[AttitudeRow]]
    """Attitudes."""
    satellite: NotRequired[list[Fact]]
    """Satellite and orbit."""
    instruments: NotRequired[list[Instrument]]
    """Gyro and sensors."""


class ExportDocument(TypedDict):
    """Exported files."""

    files: list[str]
    """Paths of the written files."""
    warnings: list[str]
    """Warnings, each with what to do."""


class CheckDocument(TypedDict):
    """Comparison of the compiled filter with filterpy."""

    agrees: bool
    """Whether both filters agree within the tolerance."""
    tolerance: float
    """Largest permitted relative difference of a variance."""
    n_designs: int
    """Number of random plans."""
    n_samples: int
    """Number of filter steps at which the variances were compared."""
    has_equal_ends: bool
    """Whether both filters have the same convergence time for every plan."""
    max_difference: float
    """Largest relative difference of a variance."""


class PredictedEnd(TypedDict):
    """Predicted results at the convergence time of a plan."""

    t_end_s: float
    """Convergence time after the epoch."""
    trace: float
    """Trace of the scaled covariance."""
    attitude_1sigma_deg: float
    """Attitude accuracy, 1-sigma about the worst body axis."""
    converged: bool
    """Whether the convergence rule of the scenario is satisfied."""
    hold_end_s: NotRequired[float]
    """Time until which the last rates are held, if the plan has a hold."""
    slew_back_end_s: NotRequired[float]
    """End of the slew back to the initial attitude, if the plan has one."""


class StateAccuracy(TypedDict):
    """Accuracy of one state, 1-sigma."""

    state: str
    """State, such as "gyro bias x"."""
    unit: str
    """Unit of the 1-sigmas."""
    before: float
    """1-sigma before the plan, in `unit`."""
    after: float
    """Predicted 1-sigma, in `unit`."""
    after_before: float
    """Predicted 1-sigma divided by the 1-sigma before the plan."""


class PlanFile(TypedDict):
    """Maneuver plan. Only `scenario` and `design` are used when a plan file is read."""

    format: str
    """Always "mgeo-attitude-plan"."""
    version: int
    """Version of the file format."""
    scenario: dict[str, Any]
    """All keys of the scenario, as in a scenario file."""
    design: list[float]
    """Body rates x, y, z [deg/s] and duration [s] of each maneuver, one after the other."""
    predicted: PredictedEnd
    """Prediction at the convergence time."""
    constraints: list[Constraint]
    """Constraints of the scenario."""
    timeline: list[AttitudeRow]
    """Phases with rates and attitudes."""
    accuracy: list[StateAccuracy]
    """Accuracy of each state before and after the plan."""


DOCUMENTS = {
    "attitude-show": Document("mgeo attitude show", (PlanDocument,)),
    "attitude-export": Document("mgeo attitude export", (ExportDocument,)),
    "attitude-check": Document("mgeo attitude check", (CheckDocument,)),
    "plan.json": Document("plan.json", (PlanFile,)),
}
