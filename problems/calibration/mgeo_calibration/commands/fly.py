"""``mgeo attitude fly``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from mgeo_attitude.commands.files import Picked
from mgeo_attitude.environment.times import elapsed
from mgeo_attitude.geometry.quaternion import quaternions
from mgeo_attitude.plan.documents import opened, read_document, scenario_of, written
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.scenario.prior import check_quaternion, states_of
from mgeo_attitude.settings.errors import expect
from scipy.spatial.transform import Rotation

from mgeo.cli.output import Output
from mgeo.terminal import note, plain, titled
from mgeo.validation.tables import entry
from mgeo_calibration.calibration.corrections import in_units, telemetry_units
from mgeo_calibration.commands.files import write_together
from mgeo_calibration.telemetry.telemetry import Telemetry, Truth

SIMULATORS = ("own", "basilisk")

FORMAT = "mgeo-attitude-truth"
VERSION = 1

#: A plan begins where the flight before has ended, but for rounding [s].
_SAME_INSTANT = 1e-3


def read_truth(path: Path, plan: ManeuverPlan) -> Truth:
    """The truth that a flight has written, if a plan goes on from it.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError, TypeError
        Naming the file and the key: no truth, of another satellite, or of another instant.
    """
    return read_document(path, lambda text: _truth(text, plan))


def _truth(text: str, plan: ManeuverPlan) -> Truth:
    table = opened(text, FORMAT, VERSION)
    before = scenario_of(table)
    entry(table, "states", dict)
    states = states_of(table, plan.scenario.suite)
    rows = [entry(states, block, list[float], "states.") for block in states]
    expect({len(row) for row in rows} == {3}, "states", states, "three numbers each")
    quaternion = entry(table, "quaternion", list[float])
    check_quaternion(quaternion)
    time = float(entry(table, "time_s", float))
    gap = elapsed(before.epoch, plan.scenario.epoch) - time
    start = f"the epoch of the plan, {time + gap:.6f} s after {before.epoch.isoformat()}"
    expect(abs(gap) < _SAME_INSTANT, "time_s", time, start)
    attitude = Rotation.from_quat(quaternion).as_matrix().T
    return Truth(attitude=attitude[None], states=np.concatenate([np.zeros(3), *rows])[None])


def flown(
    plan: ManeuverPlan,
    simulator: str,
    vehicle: str | None,
    seed: int,
    after: Truth | None = None,
) -> Telemetry:
    """Telemetry of a flight.

    Raises
    ------
    ValueError
        For an unknown simulator, a vehicle that is unknown or not flown, or from the simulator.
    ImportError
        If the simulator is not installed.
    """
    if simulator not in SIMULATORS:
        raise ValueError(f"--simulator {simulator}: expected one of {', '.join(SIMULATORS)}")
    scenario, environment = plan.scenario, plan.problem.environment
    if simulator == "own":
        from mgeo_calibration.flight.own import fly

        if vehicle is not None:
            raise ValueError("--vehicle: the own simulation has none; see --simulator basilisk")
        return fly(scenario, plan, seed, after=after, environment=environment)
    from mgeo_calibration.flight.basilisk.fly import fly as fly_basilisk
    from mgeo_calibration.flight.basilisk.vehicle import Vehicle

    coiled = scenario.turned_by_coils and vehicle is None
    chosen = None if coiled else Vehicle.of(scenario, vehicle)
    return fly_basilisk(scenario, plan, seed, vehicle=chosen, after=after, environment=environment)


def truth_document(
    plan: ManeuverPlan, telemetry: Telemetry, simulator: str, seed: int
) -> dict[str, Any]:
    """What was true at the last sample, under the names that calibration.json has for it.

    ``table`` has ``value`` where a calibration's has ``estimate``.
    """
    assert telemetry.truth is not None
    suite = plan.scenario.suite
    states = telemetry.truth.states[-1]
    return {
        "format": FORMAT,
        "version": VERSION,
        "scenario": plan.scenario.to_dict(),
        "design": list(plan.design),
        "simulator": simulator,
        "seed": seed,
        "time_s": float(telemetry.times[-1]),
        "quaternion": quaternions(telemetry.truth.attitude[-1:])[0].tolist(),
        "states": dict(zip(suite.blocks[1:], states.reshape(-1, 3)[1:].tolist(), strict=True)),
        "table": [
            {"block": block, "axis": axis, "unit": unit.text, "value": float(value)}
            for block, unit in telemetry_units(suite).items()
            for axis, value in zip("xyz", in_units(suite, states, block), strict=True)
        ],
    }


def write_flight(
    telemetry: Telemetry, out: Path, truth: Path | None, document: Any, overwrite: bool
) -> list[str]:
    """Write telemetry and truth; their paths. Raises as `write_together`."""
    if truth is None:
        telemetry.to_csv(out)
        return [str(out)]
    contents = {out: telemetry.csv().encode(), truth: written(document).encode()}
    return write_together(contents, overwrite)


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
