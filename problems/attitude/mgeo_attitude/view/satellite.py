"""Description of a satellite and its scenario, displayed before a search and in reviews."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import EARTH_RADIUS
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.validity import find_validity_violations, list_validity_ranges
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.settings.base import get_annotation
from mgeo_attitude.settings.types import Unit
from mgeo_attitude.trajectory.trajectory import Trajectory
from mgeo_attitude.view.margins import compute_interval_margins

#: Largest number of eclipses in the description of the Sun.
_MAX_ECLIPSES = 4
_UNIT_SUFFIX = re.compile(r"_(deg|nt|arcsec)(_per_.*)?$")


def describe_satellite(problem: AttitudeManeuverProblem) -> dict[str, str]:
    """Return a description of a satellite and its scenario, as a dict of texts by topic.

    The topics are satellite, orbit, Sun, magnetic field, maneuvers, constraint margins at rest, and
    validity of the covariance. The computation takes about 0.1 s.
    """
    scenario, environment = problem.scenario, problem.environment
    edges = format_time_stamps(scenario.epoch, np.array([0.0, _compute_end(scenario)]))
    start, end = (text[:19] for text in edges)
    topics = {
        "satellite": f"{scenario.name}, {start} to {end} UTC",
        "orbit": _describe_orbit(environment),
        "Sun": _describe_sun(scenario, environment),
        "field": _describe_field(environment),
        "maneuvers": _describe_maneuvers(scenario),
    }
    at_rest = list(format_rest_margins(problem))
    if at_rest:
        topics["at rest"] = f"initial attitude until {end[11:19]}: {'; '.join(at_rest)}"
    topics["covariance"] = _describe_validity(scenario)
    return topics


def _compute_end(scenario: Scenario) -> float:
    """Return the end of the scenario or the latest end of a plan, whichever is earlier [s]."""
    return min(scenario.duration, scenario.deadline)


def _describe_orbit(environment: Environment) -> str:
    position, velocity = environment.position, environment.velocity
    altitude = 1e-3 * (np.linalg.norm(position, axis=1) - EARTH_RADIUS)
    normal = np.cross(position[0], velocity[0])
    inclination = np.degrees(np.arccos(normal[2] / np.linalg.norm(normal)))
    node = ascending_node_solar_time(position[0], velocity[0], environment.sun[0])
    hours, minutes = divmod(round(60.0 * node), 60)
    return (
        f"{altitude.min():.0f} to {altitude.max():.0f} km above the Earth's equatorial radius, "
        f"inclination {inclination:.2f} deg, ascending node at {hours % 24:02d}:{minutes:02d} "
        "local solar time"
    )


def ascending_node_solar_time(position: Floats, velocity: Floats, sun: Floats) -> float:
    """Return the apparent local solar time of the ascending node of an orbit [h], from 0 to 24.

    The time is 12 h if the node has the right ascension of the Sun, and 1 h later for each 15 deg
    farther east.

    Parameters
    ----------
    position, velocity, sun : array, shape (3,)
        Satellite position, satellite velocity and Sun direction in inertial axes, of any length.
    """
    normal = np.cross(position, velocity)
    node = np.arctan2(normal[0], -normal[1])
    east = np.degrees(node - np.arctan2(sun[1], sun[0]))
    return float((12.0 + east / 15.0) % 24.0)


def _describe_sun(scenario: Scenario, environment: Environment) -> str:
    normal = np.cross(environment.position[0], environment.velocity[0])
    beta = np.degrees(np.arcsin(environment.sun[0] @ normal / np.linalg.norm(normal)))
    text = f"{beta:+.1f} deg from the orbital plane"
    if not scenario.eclipse:
        return f"{text}; eclipses are not modeled"
    is_shown = environment.times <= _compute_end(scenario)
    dark = np.concatenate([[False], ~environment.sunlit[is_shown], [False]])
    edges = np.flatnonzero(np.diff(dark)).reshape(-1, 2)
    if not len(edges):
        return f"{text}; no eclipse"
    times = np.append(environment.times[is_shown], environment.times[is_shown][-1])
    stamps = [format_time_stamps(scenario.epoch, times[edge]) for edge in edges[:_MAX_ECLIPSES]]
    listed = ", ".join(f"{a[11:19]} to {b[11:19]}" for a, b in stamps)
    more = f" and {len(edges) - _MAX_ECLIPSES} more" if len(edges) > _MAX_ECLIPSES else ""
    return f"{text}; in the Earth's shadow {listed} UTC{more}, {dark[1:-1].mean():.0%} of the time"


def _describe_field(environment: Environment) -> str:
    strength = np.linalg.norm(environment.field, axis=1)
    return f"{strength.min():,.0f} to {strength.max():,.0f} nT"


def _describe_maneuvers(scenario: Scenario) -> str:
    limits = scenario.maneuvers
    text = f"{limits.count} maneuvers of at most {limits.max_rate_deg_s:g} deg/s about each axis"
    if limits.max_acceleration_deg_s2 is not None:
        text += f", {limits.max_acceleration_deg_s2:g} deg/s²"
    actuators = (
        "magnetorquers" if scenario.is_magnetorquer_driven else "wheels" if scenario.wheels else ""
    )
    return (
        text
        + (f", by {actuators}" if actuators else "")
        + (", and a slew back" if limits.slew_back else "")
    )


def format_rest_margins(problem: AttitudeManeuverProblem) -> Iterator[str]:
    """Yield one line of text for each path constraint and each wheel budget, with its margin while
    the satellite holds its initial attitude.

    The attitude uncertainty is that of the start. There are no lines for magnetorquers, which
    cannot hold an attitude.
    """
    scenario, model = problem.scenario, problem.model
    wheels = scenario.wheels
    is_constrained = bool(scenario.path_constraints) or (
        wheels is not None and wheels.has_momentum_budget
    )
    if not is_constrained or scenario.is_magnetorquer_driven:
        return
    end = model.step * min(int(_compute_end(scenario) / model.step), model.n_steps)
    design = np.zeros(VARIABLES_PER_MANEUVER * scenario.maneuvers.count)
    trajectory = Trajectory(scenario, model, design, end, end)
    covariance = scenario.initial_attitude_covariance
    rows = compute_interval_margins(model, trajectory, 0.0, end, covariance, "at rest")
    for label, (unit, value, bound_type, bound, margin) in rows.items():
        state = "margin" if margin >= 0.0 else "EXCEEDED by"
        yield (
            f"{label.removesuffix(' at rest')} {value:.3g} {unit}, {bound_type} {bound:.3g} "
            f"{unit}, {state} {abs(margin):.2g} {unit}"
        )


def _describe_validity(scenario: Scenario) -> str:
    if scenario.prior is not None:
        return "valid: the errors after a calibration are small"
    beyond = find_validity_violations(scenario)
    if beyond:
        return f"{'; '.join(beyond)}: verify a plan"
    values = [
        f"{key} = {value:g} (to {at:g})"
        for key, value, at in list_validity_ranges(scenario)
        if value
    ]
    return f"valid for the initial errors: {', '.join(values)}"


def build_instrument_table(scenario: Scenario) -> pd.DataFrame:
    """Return a table of the gyro and the sensors with their noise, sampling interval and initial
    errors, one row per instrument.

    Returns
    -------
    DataFrame
        One row per instrument. Columns: ``kind``, ``noise``, ``every [s]`` and ``errors at the
        start, 1-sigma``, all as text.
    """
    suite = scenario.suite
    sigma = suite.initial_sigma(np.radians(scenario.initial.attitude_deg)).reshape(-1, 3)
    errors: dict[str, list[str]] = {}
    for name, unit, values in zip(suite.blocks, list_block_units(suite), sigma, strict=True):
        owner, _, error = name.rpartition(".")
        text = f"{error.replace('_', ' ')} {values.max() * unit.factor:.3g} {unit.unit}"
        errors.setdefault(owner, []).append(text.removesuffix(" -"))
    rows = {}
    instruments: list[tuple[str, Any]] = [("gyro", suite.gyro)]
    instruments += [(sensor.name, sensor) for sensor in suite.sensors]
    for name, instrument in instruments:
        units = {
            key: get_annotation(type(instrument), key, Unit) for key in instrument.noise_parameters
        }
        noise = [
            f"{_UNIT_SUFFIX.sub('', key).replace('_', ' ')} "
            f"{_format_numbers(getattr(instrument, key))} {unit.text if unit else ''}".strip()
            for key, unit in units.items()
        ]
        interval = getattr(instrument, "sample_interval", None) or scenario.step
        rows[name] = {
            "kind": getattr(instrument, "kind", "gyro"),
            "noise": ", ".join(noise),
            "every [s]": f"{interval:g}",
            "errors at the start, 1-sigma": ", ".join(errors.get(name, [])),
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("")


def _format_numbers(value: float | tuple[float, ...]) -> str:
    return " / ".join(f"{v:g}" for v in (value if isinstance(value, tuple) else (value,)))
