"""Simulation and output of the command ``mgeo attitude fly``."""

from __future__ import annotations

import pandas as pd
from mgeo_attitude.commands.files import SelectedPlan
from mgeo_attitude.plan.plan import ManeuverPlan

from mgeo.terminal import Output, build_titled_table, escape_text, format_note
from mgeo_calibration.telemetry.telemetry import Telemetry, Truth


def simulate_plan(
    plan: ManeuverPlan,
    simulator: str,
    vehicle: str | None,
    seed: int,
    initial_truth: Truth | None = None,
) -> Telemetry:
    """Simulate one run of a plan with the selected simulator, and return the telemetry.

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


#: Note on simulated runs with magnetorquers.
_MAGNETORQUER_NOTE = format_note(
    "magnetorquers act in the true attitude, which is not controlled to the plan"
)


def format_constraints(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a copy of a constraint table for the terminal. The columns ``bound`` and ``limit``
    become one text such as ``at most 5``, and rows without a limit have blank cells.
    """
    shown = frame.drop(columns="bound")
    limits = zip(frame["bound"], frame["limit"], strict=True)
    shown["limit"] = [f"{bound} {limit:.4g}" if bound else "" for bound, limit in limits]
    none = (frame["bound"] == "").to_numpy()
    for name in {"satisfied", "violated [%]"} & set(shown.columns):
        shown[name] = ["" if n else value for n, value in zip(none, shown[name], strict=True)]
    return shown


def print_simulation(
    picked: SelectedPlan,
    telemetry: Telemetry,
    comparison: pd.DataFrame,
    simulator: str,
    files: list[str],
    output: Output,
) -> None:
    """Print the plan of a simulated run, its comparison with the run, and the list of written
    files.

    Parameters
    ----------
    comparison : DataFrame
        Result of `compare_with_plan`.
    """
    output.print(
        escape_text(picked.summary, "bold"),
        *picked.list_warnings(),
        *(
            f"Note: the plan violates a constraint: {line}"
            for line in picked.plan.list_violations()
        ),
        f"{len(telemetry.times)} samples to {telemetry.times[-1]:.6g} s of gyro, "
        f"{', '.join(telemetry.sensors)}, simulator {simulator}",
        *build_titled_table(
            f"Plan and simulation until {comparison.attrs['time_s']:.6g} s",
            format_constraints(comparison),
        ),
        format_note("values of plan and simulation without margin"),
        *([_MAGNETORQUER_NOTE] if picked.plan.scenario.is_magnetorquer_driven else []),
        *(f"wrote {file}" for file in files),
    )
