"""Runs of the independent simulator, most of them with one fault. The number of a case determines
its fault.

::

    python -m tests.calibration.calibration.faulty_runs --cases 212 --out FILE.csv

A case is right if it is consistent and agrees with the truth. If it raises an error or is
inconsistent, the first line of the message identifies the cause or another cause. A case that is
consistent and wrong is silent.
"""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np
import pandas as pd
from mgeo_attitude import Scenario
from mgeo_attitude.environment.frames import gcrs_to_itrs
from mgeo_attitude.environment.times import compute_julian_dates
from mgeo_attitude.sensors import StarTracker
from mgeo_calibration import Telemetry, calibrate
from mgeo_calibration import simulate_telemetry as fly_plan

from tests.calibration.calibration import faults
from tests.calibration.calibration.faults import (
    change_gyro,
    change_sensor,
    change_times,
    count_days_since,
    random_axis,
    random_sign,
)
from tests.calibration.calibration.independent_simulator import (
    Rate,
    TrueErrors,
    coning_motion,
    constant_rates,
    simulate_readings,
    tumbling_motion,
)
from tests.calibration.calibration.runs import normalize_error, short

SEED, DURATION = 4800, 600.0
#: Largest error in 1-sigmas that agrees with the truth; one in 15,000 normal numbers is larger.
CHANCE = 4.0
PLAN = [0.5, 0.3, -0.2, 90.0, -0.3, 0.6, 0.2, 120.0, 0.2, -0.4, 0.7, 150.0, -0.6, 0.4, 0.3, 120.0]
SCENARIO = short(Scenario.cubesat_6u(), DURATION)
TRACKED = short(
    Scenario.cubesat_6u(), DURATION, sensors=(*SCENARIO.sensors, StarTracker(max_rate_deg_s=3.0))
)
MOTIONS: tuple[Callable[[np.random.Generator], Rate], ...] = (
    lambda rng: constant_rates(PLAN),
    lambda rng: coning_motion(rng.uniform(0.3, 2.0), rng.uniform(0.05, 0.5)),
    lambda rng: tumbling_motion(
        (0.185, 0.144, 0.061), rng.uniform(0.5, 2.7) * random_axis(rng), DURATION
    ),
)
TelemetryChange = Callable[[Telemetry, np.random.Generator], Telemetry]


@dataclass(frozen=True)
class FaultKind:
    """Kind of fault and the start of its message; the message is empty for cases that must be
    right.
    """

    cause: str = ""
    craft: Callable[[np.random.Generator], TrueErrors] = lambda rng: TrueErrors()
    spoil: TelemetryChange = lambda telemetry, rng: telemetry
    moves: int | None = None  # Index of MOTIONS. Default: random.
    scenario: Scenario = SCENARIO

    def fly(self, rng: np.random.Generator) -> Telemetry:
        which = int(rng.integers(len(MOTIONS))) if self.moves is None else self.moves
        if self.scenario is TRACKED:
            flown = fly_plan(TRACKED, PLAN, rng)
        else:
            flown = simulate_readings(SCENARIO, MOTIONS[which](rng), rng, self.craft(rng), DURATION)
        warm = {"temperature": faults.temperature(flown.times)}
        return self.spoil(dataclasses.replace(flown, housekeeping=warm), rng)


@dataclass(frozen=True)
class CaseResult:
    """Outcome of a case: right, named, another cause or silent, with the message."""

    number: int
    kind: str
    outcome: str
    said: str


def with_random_size(where: str, change: Callable, low: float, high: float) -> TelemetryChange:
    """Return a change of readings whose size is log-uniform between two bounds."""

    def spoil(telemetry: Telemetry, rng: np.random.Generator) -> Telemetry:
        made = change(float(np.exp(rng.uniform(np.log(low), np.log(high)))))
        one = change_gyro(made) if where == "gyro" else change_sensor(where, made)
        return one(telemetry, rng)

    return spoil


def with_latency(name: str, side: float) -> Callable[[np.random.Generator], TrueErrors]:
    return lambda rng: TrueErrors(late={name: side * np.exp(rng.uniform(np.log(0.3), np.log(3.0)))})


def insert_spikes(size: float, share: float) -> Callable:
    """Return a change that replaces a share of the readings by random vectors."""

    def change(t: np.ndarray, rows: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        rows[rng.random(len(rows)) < share] = size * random_axis(rng)
        return rows

    return change


def add_torquer_field(telemetry: Telemetry, rng: np.random.Generator) -> Telemetry:
    """Add the field of torque rods to the magnetometer; their dipole is a housekeeping channel."""
    dipole = 0.2 * np.sign(np.sin(2.0 * np.pi * telemetry.times / rng.uniform(40.0, 200.0)))
    field = telemetry.sensors["mag"] + np.outer(dipole, rng.uniform(2e3, 2e4) * random_axis(rng))
    return dataclasses.replace(
        telemetry, sensors=telemetry.sensors | {"mag": field}, housekeeping={"coil_x": dipole}
    )


def change_quaternions(change: Callable[[np.ndarray], np.ndarray]) -> TelemetryChange:
    return change_sensor("tracker", lambda t, rows, rng: change(rows))


def convert_positions_to_itrf(telemetry: Telemetry, rng: np.random.Generator) -> Telemetry:
    position, _ = SCENARIO.orbit.propagate(SCENARIO.epoch, telemetry.times)
    rotation = gcrs_to_itrs(compute_julian_dates(SCENARIO.epoch, telemetry.times))
    return dataclasses.replace(telemetry, position=np.einsum("nij,nj->ni", rotation, position))


def freeze_samples(low: float, high: float) -> Callable:
    """Return a change that repeats one sample for a share of the run."""

    def change(t: np.ndarray, rows: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        count = int(rng.uniform(low, high) * len(rows))
        a = int(rng.integers(1, len(rows) - count))
        rows[a : a + count] = rows[a]
        return rows

    return change


def without_times(change: Callable) -> Callable:
    """Return a change of readings that does not depend on the times."""
    return lambda t, rows, rng: change(rows, rng)


def rotate_mounting(rows: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Rotate the readings by 90 deg about a random axis."""
    k = int(rng.integers(3))
    i, j = (k + 1) % 3, (k + 2) % 3
    found = rows.copy()
    found[:, i], found[:, j] = rows[:, j], -rows[:, i]
    return found


# A change that exceeds the prior is also identified by the prior test.
CHANGES = r"\.bias (changes by |depends on temperature by |differs from its prior)"
DRIFTS = r"gyro\.bias (drifts|decays|changes|depends on temperature|differs from its prior)"
AXES = " agrees with the other sensors if its axes are |{0}\\.misalignment differs from its prior"
KINDS = {
    # Cases that must be right.
    "healthy": FaultKind(),
    "coning": FaultKind(moves=1),
    "tumble": FaultKind(moves=2),
    "counts of the gyro": FaultKind(
        craft=lambda rng: TrueErrors(gyro_step_deg_s=rng.uniform(2e-3, 0.02))
    ),
    "counts of the magnetometer": FaultKind(
        craft=lambda rng: TrueErrors(mag_step_nt=rng.uniform(50, 500))
    ),
    "instantaneous rates": FaultKind(
        "gyro rates precede", craft=lambda rng: TrueErrors(instantaneous=True)
    ),
    "spikes of the gyro": FaultKind(
        spoil=with_random_size("gyro", lambda s: insert_spikes(s, 0.003), 1.0, 30.0)
    ),
    "spikes of the magnetometer": FaultKind(
        spoil=with_random_size("mag", lambda s: insert_spikes(s, 0.01), 5e4, 1e9)
    ),
    "spikes of the Sun sensor": FaultKind(
        spoil=with_random_size("sun", lambda s: insert_spikes(s, 0.01), 1.0, 1e3)
    ),
    # Faults that score tests identify.
    "magnetometer late": FaultKind("mag readings lag", with_latency("mag", 1.0)),
    "magnetometer early": FaultKind("mag readings precede", with_latency("mag", -1.0)),
    "Sun sensor late": FaultKind("sun readings lag", with_latency("sun", 1.0)),
    "magnetometer's scale": FaultKind(
        r"mag\.scale_factor is ", spoil=with_random_size("mag", faults.add_scale_error, 0.003, 0.05)
    ),
    "soft iron": FaultKind(
        r"mag\.nonorthogonality is ",
        spoil=with_random_size("mag", faults.add_nonorthogonality, 0.2, 4.0),
    ),
    "gyro's scale": FaultKind(
        r"gyro\.(scale_factor|nonorthogonality) is ",
        spoil=with_random_size("gyro", faults.add_scale_error, 6e-3, 0.1),
    ),
    "step of the magnetometer": FaultKind(
        "mag" + CHANGES, spoil=with_random_size("mag", faults.add_step, 200, 5e3)
    ),
    "step of the Sun sensor": FaultKind(
        "sun" + CHANGES, spoil=with_random_size("sun", faults.add_step, 0.01, 0.1)
    ),
    "step of the gyro": FaultKind(
        DRIFTS, spoil=with_random_size("gyro", faults.add_step, 4e-3, 0.1)
    ),
    "drift of the magnetometer": FaultKind(
        "mag" + CHANGES, spoil=with_random_size("mag", faults.add_drift, 300, 5e3)
    ),
    "drift of the gyro": FaultKind(
        DRIFTS, spoil=with_random_size("gyro", faults.add_drift, 6e-3, 0.1)
    ),
    "temperature": FaultKind(
        "mag" + CHANGES, spoil=with_random_size("mag", faults.add_temperature_bias, 300, 5e3)
    ),
    "asymmetry of the gyro": FaultKind(
        r"gyro\.(scale_asymmetry|scale_factor) is ",
        spoil=with_random_size("gyro", faults.add_scale_asymmetry, 6e-3, 0.05),
    ),
    "misalignment and temperature": FaultKind(
        r"mag\.(misalignment|bias) depends on temperature by |mag\.bias changes",
        spoil=with_random_size("mag", faults.add_temperature_misalignment, 0.5, 5.0),
    ),
    "torquers": FaultKind(
        r"mag(\.bias depends on coil_x by | at .* bias_sensitivities)", spoil=add_torquer_field
    ),
    "orbit": FaultKind(
        "(the satellite is .* the declared orbit|mag at .* correct epoch and orbit)",
        lambda rng: TrueErrors(
            behind=random_sign(rng) * np.exp(rng.uniform(np.log(3.0), np.log(900.0)))
        ),
    ),
    # Faults that checks without an attitude identify.
    "magnetometer frozen": FaultKind(
        "mag at .*equal samples", spoil=change_sensor("mag", freeze_samples(0.1, 0.5))
    ),
    "Sun sensor frozen": FaultKind(
        "sun at .*equal samples", spoil=change_sensor("sun", freeze_samples(0.1, 0.5))
    ),
    "gyro frozen": FaultKind(
        "gyro at .*equal samples", spoil=change_gyro(freeze_samples(0.1, 0.5))
    ),
    **{name: FaultKind(cause, spoil=spoil) for name, (cause, spoil) in faults.GROSS.items()},
    "ITRF": FaultKind("position at .* look like ITRF", spoil=convert_positions_to_itrf),
    "days since 1970": FaultKind(
        "time at .* Declare time_epoch", spoil=count_days_since(1970, 1, 1)
    ),
    "hours": FaultKind(
        "time at .* Declare .*time_unit", spoil=change_times(lambda t, rng: t / 3600.0)
    ),
    "magnetometer 90 deg off": FaultKind(
        "mag" + AXES.format("mag"), spoil=change_sensor("mag", without_times(rotate_mounting))
    ),
    "Sun sensor 90 deg off": FaultKind(
        "sun" + AXES.format("sun"), spoil=change_sensor("sun", without_times(rotate_mounting))
    ),
    "unit vectors": FaultKind(
        'sun: .*Use kind = "two-axis-sun-sensor" instead of',
        lambda rng: TrueErrors(unit_vectors=True),
    ),
    "magnetometer in uT": FaultKind(
        "mag at .* unit = 'uT'", spoil=change_sensor("mag", lambda t, rows, rng: 1e-3 * rows)
    ),
    "quaternion scalar first": FaultKind(
        "tracker: .*read as scalar first",
        spoil=change_quaternions(lambda q: q[:, [3, 0, 1, 2]]),
        scenario=TRACKED,
    ),
    "quaternion conjugated": FaultKind(
        "tracker: .*read as from the body",
        spoil=change_quaternions(lambda q: q * [-1, -1, -1, 1]),
        scenario=TRACKED,
    ),
}


def run_case(number: int, name: str | None = None) -> CaseResult:
    """Simulate and calibrate a case, whose kind follows from its number unless given."""
    name = name or list(KINDS)[number % len(KINDS)]
    kind = KINDS[name]
    telemetry = kind.fly(np.random.default_rng([SEED, number]))
    try:
        found = calibrate(kind.scenario, telemetry)
    except ValueError as error:
        return _classify_message(number, name, str(error))
    if not found.is_consistent:
        return _classify_message(number, name, str(found.failures[0]))
    _, z = normalize_error(found, telemetry)
    off = float(np.abs(z[3:]).max())
    doubts = [note for note in found.notes if kind.cause and faults.names_cause(kind.cause, note)]
    if off >= CHANCE and doubts:  # Telemetry cannot distinguish both.
        return CaseResult(number, name, "named", doubts[0])
    return CaseResult(
        number, name, "right" if off < CHANCE else "silent", f"off by {off:.1f} sigma"
    )


def _classify_message(number: int, name: str, line: str) -> CaseResult:
    cause = KINDS[name].cause
    right = bool(cause) and faults.names_cause(cause, line)
    return CaseResult(number, name, "named" if right else "another cause", line)


def main() -> None:
    """Run the cases, print wrong results, and count the outcomes by kind."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=len(KINDS), help="number of cases")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", help="CSV file of the outcomes by kind")
    given = parser.parse_args()
    with ProcessPoolExecutor(given.jobs) as pool:
        results = list(pool.map(run_case, range(given.cases), chunksize=4))
    for result in results:
        if result.outcome in ("another cause", "silent"):
            print(f"{result.number:5} {result.kind}: {result.outcome}: {result.said[:150]}")
    counts = pd.crosstab([each.kind for each in results], [each.outcome for each in results])
    print(counts.to_string())
    if given.out:
        counts.to_csv(given.out, lineterminator="\n")
    told = counts.sum().reindex(["named", "another cause"], fill_value=0)
    print(f"cause named right: {told['named'] / max(told.sum(), 1):.1%} of all reported faults")


if __name__ == "__main__":
    main()
