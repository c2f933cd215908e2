"""Description of a satellite and its scenario, displayed before a search and in reviews."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from mgeo._text import format_duration
from mgeo_attitude._typing import Floats
from mgeo_attitude.criteria.constraints import list_constraints
from mgeo_attitude.environment.constants import EARTH_RADIUS
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.criteria import Convergence, MonteCarloSettings
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.validity import find_validity_violations
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.settings.base import get_annotation
from mgeo_attitude.settings.types import Unit
from mgeo_attitude.trajectory.trajectory import Trajectory
from mgeo_attitude.view.margins import MarginRow, compute_interval_margins

_UNIT_SUFFIX = re.compile(r"_(deg|nt|arcsec)(_per_.*)?$")


def describe_satellite(problem: AttitudeManeuverProblem) -> dict[str, str]:
    """Describe a satellite and its scenario by short texts, keyed by topic.

    The topics are satellite, time span, orbit, ascending node, Sun, eclipses, magnetic field,
    maneuvers, body rates, actuators, slew back, convergence, Monte Carlo runs, constraints and
    initial errors. Path constraints and wheel budgets include the margin if the satellite holds its
    initial attitude. The computation takes about 0.1 s.
    """
    scenario, environment = problem.scenario, problem.environment
    end = _compute_end(scenario)
    (start,) = format_time_stamps(scenario.epoch, np.array([0.0]))
    topics = {
        "satellite": scenario.name,
        "time span": f"{start[:19]} UTC, {format_duration(end)}",
        "orbit": _describe_orbit(environment),
        "ascending node": _describe_node(environment),
        "Sun": _describe_sun(environment),
        "eclipses": _describe_eclipses(scenario, environment),
        "magnetic field": _describe_field(environment),
        **_describe_maneuvers(scenario),
    }
    if scenario.monte_carlo is not None:
        topics["Monte Carlo runs"] = _describe_monte_carlo(scenario.monte_carlo)
    if rule := _describe_convergence(scenario.convergence):
        topics["convergence"] = rule
    constraints = list(_describe_constraints(problem))
    for number, text in enumerate(constraints, 1):
        topics[f"constraint {number}" if len(constraints) > 1 else "constraint"] = text
    topics["initial errors"] = _describe_validity(scenario)
    return topics


def _compute_end(scenario: Scenario) -> float:
    """Return the end of the scenario or the deadline of plans, whichever is earlier [s]."""
    return min(scenario.duration, scenario.deadline)


def _describe_orbit(environment: Environment) -> str:
    position, velocity = environment.position, environment.velocity
    altitude = 1e-3 * (np.linalg.norm(position, axis=1) - EARTH_RADIUS)
    normal = np.cross(position[0], velocity[0])
    inclination = np.degrees(np.arccos(normal[2] / np.linalg.norm(normal)))
    low, high = altitude.min(), altitude.max()
    return f"altitude {low:.0f} to {high:.0f} km, inclination {inclination:.2f} deg"


def _describe_node(environment: Environment) -> str:
    node = ascending_node_solar_time(
        environment.position[0], environment.velocity[0], environment.sun[0]
    )
    hours, minutes = divmod(round(60.0 * node), 60)
    return f"{hours % 24:02d}:{minutes:02d} apparent local solar time"


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


def _describe_sun(environment: Environment) -> str:
    normal = np.cross(environment.position[0], environment.velocity[0])
    beta = np.degrees(np.arcsin(environment.sun[0] @ normal / np.linalg.norm(normal)))
    return f"{beta:+.1f} deg from the orbital plane (beta angle)"


def _describe_eclipses(scenario: Scenario, environment: Environment) -> str:
    if not scenario.eclipse:
        return "not modeled"
    is_shown = environment.times <= _compute_end(scenario)
    dark = np.concatenate([[False], ~environment.sunlit[is_shown], [False]])
    edges = np.flatnonzero(np.diff(dark)).reshape(-1, 2)
    if not len(edges):
        return "none"
    times = np.append(environment.times[is_shown], environment.times[is_shown][-1])
    longest = times[max(edges, key=lambda edge: times[edge[1]] - times[edge[0]])]
    start, end = (text[11:19] for text in format_time_stamps(scenario.epoch, longest))
    text = f"{100.0 * dark[1:-1].mean():.0f} % of the time, the longest {start} to {end} UTC"
    if edges[0, 0] == 0:
        (first_end,) = format_time_stamps(scenario.epoch, times[edges[0, 1:]])
        text += f"; the start is in eclipse until {first_end[11:19]} UTC"
    return text


def _describe_field(environment: Environment) -> str:
    strength = np.linalg.norm(environment.field, axis=1)
    return f"{strength.min():,.0f} to {strength.max():,.0f} nT"


def _describe_maneuvers(scenario: Scenario) -> dict[str, str]:
    limits = scenario.maneuvers
    rates = f"at most {limits.max_rate_deg_s:g} deg/s"
    if limits.max_acceleration_deg_s2 is not None:
        rates += f" and {limits.max_acceleration_deg_s2:g} deg/s²"
    topics = {
        "maneuvers": f"up to {limits.count}, each with three body rates and a duration",
        "body rates": f"{rates} about each axis",
    }
    if scenario.is_magnetorquer_driven:
        topics["actuators"] = "magnetorquers"
    elif scenario.wheels:
        topics["actuators"] = "wheels"
    if limits.slew_back:
        topics["slew back"] = "to the initial pointing, at the end of the plan"
    return topics


def _describe_constraints(problem: AttitudeManeuverProblem) -> Iterator[str]:
    """Yield one line of text per constraint, with its bounds and its initial margin."""
    rows = _compute_initial_margins(problem)
    for constraint in list_constraints(problem.scenario):
        text = ", ".join(
            f"{bound.label} at {'least' if bound.is_lower else 'most'} "
            f"{bound.value * bound.factor:.3g} {bound.unit}"
            for bound in constraint.bounds
        )
        if constraint.label in rows:
            unit, value, *_, margin = rows[constraint.label]
            state = "margin" if margin >= 0.0 else "violated by"
            text += (
                f"; without maneuvers at worst {value:.3g} {unit} "
                f"({state} {abs(margin):.2g} {unit})"
            )
        yield text


def _describe_convergence(settings: Convergence) -> str:
    """Describe the convergence rule. The text is empty if plans end with the last maneuver."""
    return {
        "trace": f"when the weighted trace falls by less than {100 * settings.relative_decrease:g} "
        f"% in {format_duration(settings.window)}",
        "required": "when every 1-sigma stays within its value in required_sigma",
        "settling": f"when the weighted trace stays within {settings.factor:g} times its value at "
        "the end of the time span",
        "end": "",
    }[settings.rule]


def _describe_monte_carlo(settings: MonteCarloSettings) -> str:
    objective = "mean" if settings.mean else f"{settings.quantile:g}-quantile"
    return f"{settings.n_runs} for each plan; objectives are the {objective} of these runs"


def _compute_initial_margins(problem: AttitudeManeuverProblem) -> dict[str, MarginRow]:
    """Compute the margins of path constraints and wheel budgets if the initial attitude is held.

    The result is a dict of table rows, keyed by constraint label. The attitude uncertainty is that
    of the start. The dict is empty for magnetorquers, which cannot hold an attitude.
    """
    scenario, model = problem.scenario, problem.model
    wheels = scenario.wheels
    is_constrained = bool(scenario.path_constraints) or (
        wheels is not None and wheels.has_momentum_budget
    )
    if not is_constrained or scenario.is_magnetorquer_driven:
        return {}
    end = model.step * min(int(_compute_end(scenario) / model.step), model.n_steps)
    design = np.zeros(VARIABLES_PER_MANEUVER * scenario.maneuvers.count)
    trajectory = Trajectory(scenario, model, design, end, end)
    covariance = scenario.initial_attitude_covariance
    rows = compute_interval_margins(model, trajectory, 0.0, end, covariance, "")
    return {label.strip(): row for label, row in rows.items()}


def _describe_validity(scenario: Scenario) -> str:
    if find_validity_violations(scenario):
        return "outside of the range for which the predicted accuracy is validated"
    return "in the range for which the predicted accuracy is validated"


def build_instrument_table(scenario: Scenario) -> pd.DataFrame:
    """Return the noise, sample interval and initial errors of the gyro and each sensor.

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
        value = float(f"{values.max() * unit.factor:.3g}")  # Without an exponent, as in 3230 nT.
        text = f"{error.replace('_', ' ')} {value:g} {unit.unit}"
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
