"""Consistency checks across the tables of a scenario, warnings, and validity of the linear
covariance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from datetime import timedelta
from typing import TYPE_CHECKING, Any

import numpy as np

from mgeo_attitude.environment.constants import EARTH_RADIUS, FIELD_MODEL_END, FIELD_MODEL_START
from mgeo_attitude.environment.element_set import MAX_AGE, ElementSet
from mgeo_attitude.scenario.actuators import check_magnetorquers
from mgeo_attitude.scenario.constraints import check_windows
from mgeo_attitude.scenario.criteria import TraceWeights
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.sensors.vector_sensors import Magnetometer
from mgeo_attitude.settings.base import Settings, get_annotation, get_fields
from mgeo_attitude.settings.errors import expect, expect_unique
from mgeo_attitude.settings.types import Unit, UsualRange

if TYPE_CHECKING:
    from mgeo_attitude.scenario.scenario import Scenario

_MAX_COUNT = 2**31  # With more steps, any remainder is within the rounding error.
# These bounds limit the memory: arrays over the duration exist once, arrays over the window exist
# for each design.
_MAX_STEPS = {"duration": 1_000_000, "convergence.window": 100_000}
_ROUNDING = 1e-9  # This is relative: decimal steps such as 0.1 s are not exact in binary.

#: Geocentric distance in Earth radii above which the field of the ring current, which IGRF
#: neglects, is significant; and lowest altitude of orbits [m].
_MAX_DISTANCE, _MIN_ALTITUDE = 3.0, 100e3
#: Number of samples of the orbit for the check of its altitude.
_ALTITUDE_SAMPLES = 200


def check_consistency(scenario: Scenario, suite: Suite) -> None:
    """Raise InvalidValue if fields of a scenario contradict each other or the sensor suite.

    The message names the key, its value and the condition.
    """
    _check_durations(scenario)
    _check_rate(scenario)
    _check_sample_intervals(scenario)
    check_magnetorquers(scenario.magnetorquers, scenario.wheels, scenario.maneuvers, scenario.step)
    _check_epoch(scenario)
    check_windows(scenario)
    _check_names(scenario)
    _check_states(scenario, suite)
    _check_path_constraints(scenario)


def _check_durations(scenario: Scenario) -> None:
    """Check the duration and the convergence window against the filter step.

    Both must be multiples of the step and have an admissible number of steps.
    """
    step, window = f"step = {scenario.step!r} s", scenario.convergence.window
    for key, span in (("duration", scenario.duration), ("convergence.window", window)):
        expect(_is_multiple(span, scenario.step), key, span, f"a multiple of {step}")
        is_short = round(span / scenario.step) <= _MAX_STEPS[key]
        expect(is_short, key, span, f"at most {_MAX_STEPS[key]} times {step}")


def _check_rate(scenario: Scenario) -> None:
    """Check the maximum body rate against the gyro's range and the filter step.

    The body must rotate by less than 180 degrees per step.
    """
    step = f"step = {scenario.step!r} s"
    rate = scenario.maneuvers.max_rate_deg_s
    # Samples half a revolution apart leave the sense of rotation ambiguous.
    fastest = 180.0 / (math.sqrt(3.0) * scenario.step)
    expected = (
        f"less than {fastest:.4g}, so that a rotation at this rate about all axes is less than 180 "
        f"deg in {step}; or a step below {180.0 / (math.sqrt(3.0) * rate):.4g} s"
    )
    expect(rate < fastest, "maneuvers.max_rate_deg_s", rate, expected)
    gyro_range = scenario.gyro.range_deg_per_s
    expected = f"at most gyro.range_deg_per_s = {gyro_range!r}"
    expect(gyro_range is None or rate <= gyro_range, "maneuvers.max_rate_deg_s", rate, expected)


def _check_sample_intervals(scenario: Scenario) -> None:
    """Check sample intervals and the convergence window against the step and the duration.

    The convergence rule 'required' also needs required 1-sigmas.
    """
    step, window = f"step = {scenario.step!r} s", scenario.convergence.window
    expected = f"at most duration = {scenario.duration!r} s"
    for i, sensor in enumerate(scenario.sensors):
        interval, key = sensor.sample_interval, f"sensors[{i}].sample_interval"
        is_multiple = interval is None or _is_multiple(interval, scenario.step)
        expect(is_multiple, key, interval, f"a multiple of {step}")
        expect((interval or 0.0) <= scenario.duration, key, interval, expected)
    expect(window <= scenario.duration, "convergence.window", window, expected)
    is_possible = scenario.required_sigma or scenario.convergence.rule != "required"
    expected = "another rule, or a value in [required_sigma]"
    expect(is_possible, "convergence.rule", scenario.convergence.rule, expected)


def _check_epoch(scenario: Scenario) -> None:
    """Check that a run is within the time span of the geomagnetic field model.

    A scenario that does not need the field model may have any epoch.
    """
    epoch, start, end = scenario.epoch, FIELD_MODEL_START, FIELD_MODEL_END
    is_covered = start <= epoch <= end and scenario.latest_end <= (end - epoch).total_seconds()
    delay = ", with the largest start delay," if scenario.latest_end > scenario.duration else ""
    expected = (
        f"a run of duration = {scenario.duration!r} s{delay} inside the field model IGRF-14, from "
        f"{start:%Y-%m-%d} to {end:%Y-%m-%d} UTC, or a scenario that does not need the field "
        "(without magnetometers, magnetorquers that rotate the satellite and residual dipole)"
    )
    expect(is_covered or not scenario.needs_field, "epoch", epoch.isoformat(), expected)


def _check_names(scenario: Scenario) -> None:
    names = [sensor.name for sensor in scenario.sensors]
    expect_unique("sensors[{}].name", names)
    for i, name in enumerate(names):
        is_free = name not in ("gyro", "environment_errors")
        expect(is_free, f"sensors[{i}].name", name, "another name, since this name is reserved")
    expect_unique(
        "housekeeping_channels[{}].name",
        [channel.name for channel in scenario.housekeeping_channels],
    )


def _check_states(scenario: Scenario, suite: Suite) -> None:
    """Check the weights in the trace of the covariance and the error states of the prior.

    At least one weight must be nonzero. The prior must have the error states of the suite.
    """
    weights = TraceWeights(scenario.trace_weights)
    has_weight = any(weights.list_weights(suite.blocks, suite.uncalibrated_blocks))
    expect(has_weight, "trace_weights", dict(weights), "a weight above 0")
    if scenario.prior is not None:
        blocks, n_rows = suite.blocks[1:], len(scenario.prior.states)
        expected = f"{len(blocks)} rows, of {', '.join(blocks)}"
        expect(n_rows == len(blocks), "prior.states", f"{n_rows} rows", expected)


def _check_path_constraints(scenario: Scenario) -> None:
    """Check that the margin of every path constraint leaves an admissible attitude.

    The margin is that of the initial attitude error.
    """
    for i, constraint in enumerate(scenario.path_constraints if scenario.prior is None else ()):
        half_angle, keep_in = constraint.half_angle_deg, constraint.keep_in
        available_angle = half_angle if keep_in else 180.0 - half_angle
        max_sigmas = available_angle / scenario.initial.attitude_deg
        expected = (
            f"less than {max_sigmas:.4g}: with initial.attitude_deg = "
            f"{scenario.initial.attitude_deg!r} the margin leaves no attitude "
            f"{'inside' if keep_in else 'outside'} half_angle_deg = {half_angle!r}"
        )
        # For the disc of a body, the admissible range depends on its apparent radius.
        sigmas = constraint.attitude_sigmas
        is_feasible = sigmas < max_sigmas or constraint.build_cone().is_disc
        expect(is_feasible, f"path_constraints[{i}].attitude_sigmas", sigmas, expected)


def _is_multiple(span: float, step: float) -> bool:
    count = span / step
    return 0.5 < count < _MAX_COUNT and math.isclose(round(count) * step, span, rel_tol=_ROUNDING)


class ImplausibleValue(UserWarning):
    """Warning about a value that is likely an error, such as a number in another unit."""


def find_implausible_values(scenario: Scenario) -> tuple[str, ...]:
    """Return a warning for each value of a scenario that is likely an error.

    Implausible values are numbers outside of their usual range, an orbit outside of the range of
    the field model, and an old element set.
    """
    return (
        *_find_unusual_values(scenario),
        *_find_invalid_altitude(scenario),
        *_find_old_element_set(scenario),
    )


def _find_unusual_values(settings: Any, prefix: str = "") -> Iterator[str]:
    """Yield a warning for each nonzero number outside the `UsualRange` of its field."""
    for name in get_fields(type(settings)):
        value, key = getattr(settings, name), f"{prefix}{name}"
        values = value if isinstance(value, tuple) else (value,)
        usual_range = get_annotation(type(settings), name, UsualRange)
        unit = get_annotation(type(settings), name, Unit)
        text = f" {unit.text}" if unit else ""
        for i, each in enumerate(values):
            if isinstance(each, Settings):
                entry = f"{key}[{i}]" if values is value else key
                yield from _find_unusual_values(each, f"{entry}.")
            elif usual_range and each and not usual_range.low <= each <= usual_range.high:
                expected = f"the usual range is {usual_range.low:g} to {usual_range.high:g}{text}"
                yield f"{key} = {each:g}{text}: {expected}; check the unit"
                break


def _find_invalid_altitude(scenario: Scenario) -> Iterator[str]:
    if not any(isinstance(sensor, Magnetometer) for sensor in scenario.sensors):
        return
    times = np.linspace(0.0, scenario.latest_end, _ALTITUDE_SAMPLES)
    distance = np.linalg.norm(scenario.orbit.propagate(scenario.epoch, times)[0], axis=1)
    largest = float(distance.max()) / EARTH_RADIUS
    if largest > _MAX_DISTANCE:
        yield (
            f"orbit: {largest:.1f} Earth radii from the Earth's center: above {_MAX_DISTANCE:g} "
            "Earth radii, IGRF is inaccurate, since it neglects currents outside the Earth"
        )
    lowest = float(distance.min()) - EARTH_RADIUS
    if lowest < _MIN_ALTITUDE:
        yield (
            f"orbit: down to an altitude of {1e-3 * lowest:.0f} km: no satellite orbits below "
            f"{1e-3 * _MIN_ALTITUDE:g} km"
        )


def _find_old_element_set(scenario: Scenario) -> Iterator[str]:
    orbit = scenario.orbit
    if not isinstance(orbit, ElementSet):
        return
    age = scenario.epoch + timedelta(seconds=scenario.latest_end) - orbit.element_epoch
    if age > MAX_AGE:
        yield (
            f"orbit: at the end of the run the element set is {age / timedelta(days=1):.1f} days "
            f"old, with an error of tens of kilometers: use a set of at most {MAX_AGE.days} days"
        )


class OutsideValidity(UserWarning):
    """Warning about initial 1-sigmas outside the range in which the filter was validated.

    Within the range, the filter was found to be statistically consistent.
    """


#: Largest initial 1-sigma per axis for which the NEES of the estimator is within its 99 % bounds
#: for both presets; see docs/validation/consistency.md.
MAX_ATTITUDE_DEG = 20.0
MAX_MISALIGNMENT_DEG = 1.0
MAX_GYRO_BIAS_DEG_S = 0.01

#: Largest initial attitude 1-sigma with photodiodes, of which few are sunlit at a time. The NEES of
#: `cubesat_1u` is 1.2 from 10 deg and 1.04 from 5 deg.
MAX_PHOTODIODE_ATTITUDE_DEG = 5.0

#: Largest orbit error, limited by the change of the field gradient along the orbit. In 50 Basilisk
#: simulations with IGRF, the NEES is 1.07 with an along-track error of 30 km, which is within its
#: 99 % bounds, and 1.14 with 50 km, which is not.
MAX_ORBIT_ERROR_M = 30_000.0


def list_validity_ranges(scenario: Scenario) -> list[tuple[str, float, float]]:
    """List the largest initial 1-sigmas for which the filter was found to be consistent.

    Returns
    -------
    list of tuple
        Key in a scenario file, value, and largest value, in the unit of the key.
    """
    has_photodiodes = any(isinstance(sensor, Photodiode) for sensor in scenario.sensors)
    attitude = MAX_PHOTODIODE_ATTITUDE_DEG if has_photodiodes else MAX_ATTITUDE_DEG
    gyro, key = scenario.gyro, "initial_misalignment_deg"
    ranges = [
        ("initial.attitude_deg", scenario.initial.attitude_deg, attitude),
        ("gyro.initial_bias_deg_s", gyro.initial_bias_deg_s, MAX_GYRO_BIAS_DEG_S),
        (f"gyro.{key}", gyro.initial_misalignment_deg, MAX_MISALIGNMENT_DEG),
    ]
    if scenario.environment_errors.has_orbit_error and scenario.needs_field:
        error = max(scenario.environment_errors.orbit_error_m)
        ranges.append(("environment_errors.orbit_error_m", error, MAX_ORBIT_ERROR_M))
    return ranges + [
        (f"sensors[{index}].{key}", getattr(sensor, key, 0.0), MAX_MISALIGNMENT_DEG)
        for index, sensor in enumerate(scenario.sensors)
        if not isinstance(sensor, Photodiode)  # Its signal is linear in the tilt of its normal.
    ]


def find_validity_violations(scenario: Scenario) -> tuple[str, ...]:
    """Return a message for each initial 1-sigma that is too large for the linear covariance.

    The predicted covariance may then be overconfident. The initial uncertainties are compared with
    the ranges of docs/validation/consistency.md, in which one uncertainty at a time was varied from
    the presets. A scenario within the ranges is not guaranteed to be consistent; `simulate` tests
    it.

    Parameters
    ----------
    scenario : Scenario
        Scenario without a prior; a calibration leaves smaller errors than the ranges.

    Examples
    --------
    >>> from mgeo_attitude import Scenario, find_validity_violations
    >>> wild = Scenario.from_dict({"preset": "paper", "initial": {"attitude_deg": 60.0}})
    >>> find_validity_violations(Scenario.paper()), len(find_validity_violations(wild))
    ((), 1)
    """
    if scenario.prior is not None:  # A calibration leaves smaller errors than these bounds.
        return ()
    return tuple(
        f"{key} = {value:g}: the predicted covariance is known to be consistent up to "
        f"{upper_bound:g}"
        for key, value, upper_bound in list_validity_ranges(scenario)
        if value > upper_bound
    )
