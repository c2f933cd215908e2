"""What keys of different sections say together: refused, by an InvalidValue, if it does not fit."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from mgeo_attitude.environment.constants import FIELD_MODEL_END, FIELD_MODEL_START
from mgeo_attitude.scenario.actuators import check_coils
from mgeo_attitude.scenario.block_numbers import TraceWeights
from mgeo_attitude.scenario.windows import check_windows
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.settings.errors import expect, expect_unique

if TYPE_CHECKING:
    from mgeo_attitude.scenario.scenario import Scenario

_MAX_COUNT = 2**31  # with more steps than this any remainder would be within rounding
# What is kept of each step would fill the memory: of the run, once; of the window, for each design.
_MAX_STEPS = {"duration": 1_000_000, "convergence.window": 100_000}
_TOLERANCE = 1e-9  # relative; decimal steps such as 0.1 s are not exact in binary


def check_together(scenario: Scenario, suite: Suite) -> None:
    """Refuse what does not go with other fields of a scenario, or the suite that it makes.

    Raises
    ------
    InvalidValue
        Naming the key, its value and what it must fit.
    """
    _check_spans(scenario)
    _check_rate(scenario)
    _check_samples(scenario)
    check_coils(scenario.coils, scenario.wheels, scenario.maneuvers, scenario.step)
    _check_epoch(scenario)
    check_windows(scenario)
    _check_names(scenario)
    _check_states(scenario, suite)
    _check_limits(scenario)


def _check_spans(scenario: Scenario) -> None:
    """Duration and window are of whole steps, and not of too many."""
    step, window = f"step = {scenario.step!r} s", scenario.convergence.window
    for key, span in (("duration", scenario.duration), ("convergence.window", window)):
        expect(_is_multiple(span, scenario.step), key, span, f"a multiple of {step}")
        few = round(span / scenario.step) <= _MAX_STEPS[key]
        expect(few, key, span, f"at most {_MAX_STEPS[key]} times {step}")


def _check_rate(scenario: Scenario) -> None:
    """Rates are such as samples can tell, and within the gyro's range."""
    step = f"step = {scenario.step!r} s"
    rate = scenario.maneuvers.max_rate_deg_s
    # between samples half a turn apart nobody could tell which way the body turned
    fastest = 180.0 / (math.sqrt(3.0) * scenario.step)
    slow = (
        f"less than {fastest:.4g}, so that turned at about all axes it is less than 180 deg in "
        f"{step}; or a step below {180.0 / (math.sqrt(3.0) * rate):.4g} s"
    )
    expect(rate < fastest, "maneuvers.max_rate_deg_s", rate, slow)
    gyro_range = scenario.gyro.range_deg_per_s
    within = f"at most gyro.range_deg_per_s = {gyro_range!r}"
    expect(gyro_range is None or rate <= gyro_range, "maneuvers.max_rate_deg_s", rate, within)


def _check_samples(scenario: Scenario) -> None:
    """Intervals and window fit the run, and the rule has what it asks about."""
    step, window = f"step = {scenario.step!r} s", scenario.convergence.window
    most = f"at most duration = {scenario.duration!r} s"
    for i, sensor in enumerate(scenario.sensors):
        interval, key = sensor.sample_interval, f"sensors[{i}].sample_interval"
        fits = interval is None or _is_multiple(interval, scenario.step)
        expect(fits, key, interval, f"a multiple of {step}")
        expect((interval or 0.0) <= scenario.duration, key, interval, most)
    expect(window <= scenario.duration, "convergence.window", window, most)
    possible = scenario.required_sigma or scenario.convergence.rule != "required"
    others = "another rule, or something in required_sigma"
    expect(possible, "convergence.rule", scenario.convergence.rule, others)


def _check_epoch(scenario: Scenario) -> None:
    """The run lies where the field is modeled, if anything needs it."""
    epoch, start, end = scenario.epoch, FIELD_MODEL_START, FIELD_MODEL_END
    inside = start <= epoch <= end and scenario.latest_end <= (end - epoch).total_seconds()
    late = ", begun as late as it may be," if scenario.latest_end > scenario.duration else ""
    years = (
        f"a run of duration = {scenario.duration!r} s{late} inside the field model IGRF-14, from "
        f"{start:%Y-%m-%d} to {end:%Y-%m-%d} UTC, or nothing that needs the field, as "
        "magnetometers, coils that turn the satellite and a residual dipole do"
    )
    expect(inside or not scenario.needs_field, "epoch", epoch.isoformat(), years)


def _check_names(scenario: Scenario) -> None:
    """Sensors and channels have names of their own."""
    names = [sensor.name for sensor in scenario.sensors]
    expect_unique("sensors[{}].name", names)
    for i, name in enumerate(names):
        expect(name not in ("gyro", "world"), f"sensors[{i}].name", name, "another name")
    expect_unique("channels[{}].name", [channel.name for channel in scenario.channels])


def _check_states(scenario: Scenario, suite: Suite) -> None:
    """Some state counts, and a prior is of the states there are."""
    weights = TraceWeights(scenario.trace_weights)
    some = any(weights.of(suite.blocks, suite.uncalibrated))
    expect(some, "trace_weights", dict(weights), "a weight above 0")
    if scenario.prior is not None:
        blocks, found = suite.blocks[1:], len(scenario.prior.states)
        same = f"{len(blocks)} rows, of {', '.join(blocks)}"
        expect(found == len(blocks), "prior.states", f"{found} rows", same)


def _check_limits(scenario: Scenario) -> None:
    """No cone is so narrow that its margin for the first attitude fills it."""
    for i, limit in enumerate(scenario.path_limits if scenario.prior is None else ()):
        room = limit.half_angle_deg if limit.keep_in else 180.0 - limit.half_angle_deg
        fewest = room / scenario.initial.attitude_deg
        far = (
            f"less than {fewest:.4g}: with initial.attitude_deg = "
            f"{scenario.initial.attitude_deg!r} no attitude is that far "
            f"{'inside' if limit.keep_in else 'from'} half_angle_deg = {limit.half_angle_deg!r}"
        )
        # of a disc the angle counts from its limb: what is left depends on where that is
        fits = limit.attitude_sigmas < fewest or limit.cone().disc
        expect(fits, f"path_limits[{i}].attitude_sigmas", limit.attitude_sigmas, far)


def _is_multiple(span: float, step: float) -> bool:
    count = span / step
    return 0.5 < count < _MAX_COUNT and math.isclose(round(count) * step, span, rel_tol=_TOLERANCE)
