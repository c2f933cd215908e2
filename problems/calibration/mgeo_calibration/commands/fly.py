"""``mgeo attitude fly``."""

from __future__ import annotations

import pandas as pd
from mgeo_attitude.commands.files import Picked
from mgeo_attitude.plan.plan import ManeuverPlan

from mgeo.terminal import Output, note, plain, titled
from mgeo_calibration.telemetry.telemetry import Telemetry, Truth


def simulate_flight(
    plan: ManeuverPlan,
    simulator: str,
    vehicle: str | None,
    seed: int,
    after: Truth | None = None,
) -> Telemetry:
    """Fly the plan once by the chosen simulator.

    Raises
    ------
    ValueError
        For an unknown vehicle, a vehicle of the own simulator, or from the simulator.
    ImportError
        If the simulator is not installed.
    """
    scenario, environment = plan.scenario, plan.problem.environment
    if simulator == "own":
        from mgeo_calibration.flight.own import fly

        if vehicle is not None:
            raise ValueError("--vehicle: the own simulation has none; see --simulator basilisk")
        return fly(scenario, plan, seed, after=after, environment=environment)
    from mgeo_calibration.flight.basilisk.fly import fly as fly_basilisk
    from mgeo_calibration.flight.basilisk.vehicle import Vehicle

    chosen = Vehicle.of(scenario, vehicle) if vehicle else None
    return fly_basilisk(scenario, plan, seed, vehicle=chosen, after=after, environment=environment)


#: What a flight by coils is not.
_COILS = note("coils turn it by the field in its own attitude, which is not held to the plan's")


def limited(frame: pd.DataFrame) -> pd.DataFrame:
    """A table of what is to be kept as it fits a terminal: bound and limit in one column."""
    shown = frame.drop(columns="bound")
    limits = zip(frame["bound"], frame["limit"], strict=True)
    shown["limit"] = [f"{bound} {limit:.4g}" if bound else "" for bound, limit in limits]
    none = (frame["bound"] == "").to_numpy()
    for name in {"kept", "broken [%]"} & set(shown.columns):
        shown[name] = ["" if n else value for n, value in zip(none, shown[name], strict=True)]
    return shown


def print_flight(
    picked: Picked,
    telemetry: Telemetry,
    came_to: pd.DataFrame,
    simulator: str,
    files: list[str],
    output: Output,
) -> None:
    """Print what was flown, what it came to (`as_flown`), and where it is."""
    output.print(
        plain(picked.answer, "bold"),
        *picked.doubts(),
        *(f"Note: it breaks a limit: {line}" for line in picked.plan.violations()),
        f"{len(telemetry.times)} samples to {telemetry.times[-1]:.6g} s of gyro, "
        f"{', '.join(telemetry.sensors)}, flown by {simulator}",
        *titled(f"The plan until {came_to.attrs['time_s']:.6g} s, and as flown", limited(came_to)),
        note("both without margin"),
        *([_COILS] if picked.plan.scenario.turned_by_coils else []),
        *(f"wrote {file}" for file in files),
    )
