"""Simulation and output of the command ``mgeo attitude fly``."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from mgeo_attitude.commands.files import SelectedPlan
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.plan.summary import list_warnings

from mgeo._text import format_duration
from mgeo.plugins.review import Section, format_bounds
from mgeo.terminal import Output
from mgeo_calibration.telemetry.telemetry import Telemetry, Truth


def simulate_plan(
    plan: ManeuverPlan,
    simulator: str,
    vehicle: str | None,
    seed: int,
    initial_truth: Truth | None = None,
) -> Telemetry:
    """Simulate one run of a plan with the selected simulator, and return its telemetry.

    Parameters
    ----------
    plan : ManeuverPlan
    simulator : str
        ``kinematic`` or ``basilisk``.
    vehicle : str, optional
        Name of a Basilisk vehicle. Default: the vehicle of the scenario.
    seed : int
        Seed of the random errors.
    initial_truth : Truth, optional
        Truth of an earlier run from which the run continues.

    Raises
    ------
    ValueError
        If the vehicle is unknown, a vehicle is given for the kinematic simulator, or the simulator
        cannot simulate the plan.
    ImportError
        If the simulator is not installed.
    """
    scenario, environment = plan.scenario, plan.problem.environment
    if simulator == "kinematic":
        from mgeo_calibration.simulators.kinematic import simulate_telemetry

        if vehicle is not None:
            raise ValueError("--vehicle: expected only with --simulator basilisk. Remove --vehicle")
        return simulate_telemetry(
            scenario, plan, seed, initial_truth=initial_truth, environment=environment
        )
    from mgeo_calibration.simulators.basilisk.telemetry import (
        simulate_telemetry as simulate_with_basilisk,
    )
    from mgeo_calibration.simulators.basilisk.vehicle import Vehicle

    chosen = Vehicle.from_scenario(scenario, vehicle) if vehicle else None
    return simulate_with_basilisk(
        scenario, plan, seed, vehicle=chosen, initial_truth=initial_truth, environment=environment
    )


def build_comparison_section(title: str, frame: pd.DataFrame, note: str) -> Section:
    """Return a section with a table that compares true and planned values.

    The columns ``bound_type`` and ``bound_value`` become one text such as ``max 5``. Rows without a
    constraint have empty cells; without any constraint, the table has no columns on constraints.

    Parameters
    ----------
    title : str
    frame : DataFrame
        Result of `compare_with_plan`.
    note : str
        Text below the table.
    """
    has_bound = frame["bound_type"] != ""
    bounds = format_bounds(frame["bound_type"], frame["bound_value"].map("{:.4g}".format))
    satisfied = frame["satisfied"].map({True: "satisfied", False: "VIOLATED"})
    shown = frame.drop(columns=["bound_type", "bound_value", "satisfied"])
    shown = shown.rename(columns={"plan": "planned"})
    if has_bound.any():
        shown["constraint"] = bounds.where(has_bound, "")
        shown["result"] = satisfied.where(has_bound, "")
    return Section(title, table=shown, note=note)


def print_simulation(
    picked: SelectedPlan,
    plan_options: str,
    telemetry: Telemetry,
    comparison: pd.DataFrame,
    simulator: str,
    files: Mapping[str, str],
    output: Output,
) -> None:
    """Print the results of a simulated run, the written files, and the next command.

    Parameters
    ----------
    picked : SelectedPlan
    plan_options : str
        Options of ``calibrate`` that select the same plan.
    telemetry : Telemetry
    comparison : DataFrame
        Result of `compare_with_plan`.
    simulator : str
    files : mapping of str to str
        Written files and their contents.
    output : Output
    """
    plan = picked.plan
    readings = {"gyro": telemetry.gyro_deg_s, **telemetry.sensors}
    counts = (
        f"{np.isfinite(values).all(axis=1).sum()} of {name}" for name, values in readings.items()
    )
    output.print_title(
        f"Simulated {format_duration(telemetry.times[-1])}, the duration of the scenario, with the "
        f"{simulator} simulator: {len(telemetry.times)} samples."
    )
    output.print_text(f"Readings: {', '.join(counts)}; none at the epoch.")
    output.print_text(f"Plan: {picked.summary.removeprefix('plan ')}.")
    violations = [f"The plan violates a constraint: {line}." for line in plan.list_violations()]
    output.print_warnings([*list_warnings(plan), *violations])
    notes = ["Pointing error: rotation angle from the planned to the simulated attitude."]
    if plan.scenario.is_magnetorquer_driven:
        notes.append("Magnetorquers are commanded as planned; no controller corrects the attitude.")
    elif simulator == "kinematic":
        after = "" if plan.slew_back else " After the plan, its last rates continue."
        notes.append(
            f"The planned rates are executed exactly, so that the initial error remains.{after}"
        )
    else:
        notes.append(
            "The controller knows the attitude only from integrated gyro rates, whose errors add "
            "to the initial error."
        )
    if plan.scenario.path_constraints:
        notes.append("Angles of path constraints exclude the margin for the attitude error.")
    title = (
        f"Simulated motion until {format_duration(comparison.attrs['time_s'])}, compared with the "
        "plan"
    )
    output.print("")
    output.print_sections(build_comparison_section(title, comparison, "\n".join(notes)))
    output.print_files(files)
    commands = {"Calibrate": f"mgeo attitude calibrate {next(iter(files))} {plan_options}"}
    if len(files) == 1:
        commands["Write the true errors"] = "add --truth FILE.json"
    output.print_commands(commands)
