"""Flights of the independent simulation, of which most have a fault; each case is a number.

::

    python -m tests.calibration.calibration.faulty_flights --cases 1200 --jobs 2

A case ends right, supported and within chance of the truth; or its calibration is refused or not
supported. Then the first line names the cause, or another. What is supported and wrong is silent.
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
from tests.calibration.calibration.faults import axis, days_since, gyro, sensor, shifted, sign
from tests.calibration.calibration.flights import normalized, short
from tests.calibration.calibration.independent import Craft, Rate, coning, fly, steady, tumble

SEED, DURATION = 4800, 600.0
#: An estimate is within chance of the truth up to so many 1-sigmas: one in 15,000 normal numbers.
CHANCE = 4.0
PLAN = [0.5, 0.3, -0.2, 90.0, -0.3, 0.6, 0.2, 120.0, 0.2, -0.4, 0.7, 150.0, -0.6, 0.4, 0.3, 120.0]
SCENARIO = short(Scenario.cubesat_6u(), DURATION)
TRACKED = short(
    Scenario.cubesat_6u(), DURATION, sensors=(*SCENARIO.sensors, StarTracker(max_rate_deg_s=3.0))
)
MOTIONS: tuple[Callable[[np.random.Generator], Rate], ...] = (
    lambda rng: steady(PLAN),
    lambda rng: coning(rng.uniform(0.3, 2.0), rng.uniform(0.05, 0.5)),
    lambda rng: tumble((0.185, 0.144, 0.061), rng.uniform(0.5, 2.7) * axis(rng), DURATION),
)
Spoil = Callable[[Telemetry, np.random.Generator], Telemetry]


@dataclass(frozen=True)
class Kind:
    """What is wrong, and how its cause begins; none of what has to end right."""

    cause: str = ""
    craft: Callable[[np.random.Generator], Craft] = lambda rng: Craft()
    spoil: Spoil = lambda telemetry, rng: telemetry
    moves: int | None = None  # which of MOTIONS; any unless it says
    scenario: Scenario = SCENARIO

    def fly(self, rng: np.random.Generator) -> Telemetry:
        which = int(rng.integers(len(MOTIONS))) if self.moves is None else self.moves
        if self.scenario is TRACKED:
            flown = fly_plan(TRACKED, PLAN, rng)
        else:
            flown = fly(SCENARIO, MOTIONS[which](rng), rng, self.craft(rng), DURATION)
        warm = {"temperature": faults.temperature(flown.times)}
        return self.spoil(dataclasses.replace(flown, housekeeping=warm), rng)


@dataclass(frozen=True)
class Result:
    """How a case went: right, named, another cause or silent, and what was said."""

    number: int
    kind: str
    outcome: str
    said: str


def sized(where: str, change: Callable, low: float, high: float) -> Spoil:
    """A change of readings by a size between, as likely in each decade."""

    def spoil(telemetry: Telemetry, rng: np.random.Generator) -> Telemetry:
        made = change(float(np.exp(rng.uniform(np.log(low), np.log(high)))))
        one = gyro(made) if where == "gyro" else sensor(where, made)
        return one(telemetry, rng)

    return spoil


def late(name: str, side: float) -> Callable[[np.random.Generator], Craft]:
    return lambda rng: Craft(late={name: side * np.exp(rng.uniform(np.log(0.3), np.log(3.0)))})


def spikes(size: float, share: float) -> Callable:
    """In place of some readings."""

    def change(t: np.ndarray, rows: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        rows[rng.random(len(rows)) < share] = size * axis(rng)
        return rows

    return change


def torqued(telemetry: Telemetry, rng: np.random.Generator) -> Telemetry:
    """By torque rods beside the magnetometer, whose dipole is another column."""
    dipole = 0.2 * np.sign(np.sin(2.0 * np.pi * telemetry.times / rng.uniform(40.0, 200.0)))
    field = telemetry.sensors["mag"] + np.outer(dipole, rng.uniform(2e3, 2e4) * axis(rng))
    return dataclasses.replace(
        telemetry, sensors=telemetry.sensors | {"mag": field}, housekeeping={"coil_x": dipole}
    )


def quaternions(change: Callable[[np.ndarray], np.ndarray]) -> Spoil:
    return sensor("tracker", lambda t, rows, rng: change(rows))


def in_itrf(telemetry: Telemetry, rng: np.random.Generator) -> Telemetry:
    position, _ = SCENARIO.orbit.propagate(SCENARIO.epoch, telemetry.times)
    rotation = gcrs_to_itrs(compute_julian_dates(SCENARIO.epoch, telemetry.times))
    return dataclasses.replace(telemetry, position=np.einsum("nij,nj->ni", rotation, position))


def held(low: float, high: float) -> Callable:
    """A channel, or all, that stand still for a share of the flight."""

    def change(t: np.ndarray, rows: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        count = int(rng.uniform(low, high) * len(rows))
        a = int(rng.integers(1, len(rows) - count))
        rows[a : a + count] = rows[a]
        return rows

    return change


def rows_of(change: Callable) -> Callable:
    """A change that does not ask for times."""
    return lambda t, rows, rng: change(rows, rng)


def turned(rows: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Mounted 90 deg off, about any axis."""
    k = int(rng.integers(3))
    i, j = (k + 1) % 3, (k + 2) % 3
    found = rows.copy()
    found[:, i], found[:, j] = rows[:, j], -rows[:, i]
    return found


# one that changes by more than its prior allows is named right by that, too
CHANGES = r"\.bias (changes by |follows temperature by |is .* from its prior)"
DRIFTS = r"gyro\.bias (drifts|decays|changes|follows temperature|is .* from its prior)"
AXES = " agrees with the other sensors if its axes are |{0}\\.misalignment is .* prior sigmas"
KINDS = {
    # what has to end right
    "healthy": Kind(),
    "coning": Kind(moves=1),
    "tumble": Kind(moves=2),
    "counts of the gyro": Kind(craft=lambda rng: Craft(gyro_step_deg_s=rng.uniform(2e-3, 0.02))),
    "counts of the magnetometer": Kind(craft=lambda rng: Craft(mag_step_nt=rng.uniform(50, 500))),
    "instantaneous rates": Kind(
        "gyro reports rates .* early", craft=lambda rng: Craft(instantaneous=True)
    ),
    "spikes of the gyro": Kind(spoil=sized("gyro", lambda s: spikes(s, 0.003), 1.0, 30.0)),
    "spikes of the magnetometer": Kind(spoil=sized("mag", lambda s: spikes(s, 0.01), 5e4, 1e9)),
    "spikes of the Sun sensor": Kind(spoil=sized("sun", lambda s: spikes(s, 0.01), 1.0, 1e3)),
    # what is named by score tests
    "magnetometer late": Kind("mag is .* s late", late("mag", 1.0)),
    "magnetometer early": Kind("mag is .* s early", late("mag", -1.0)),
    "Sun sensor late": Kind("sun is .* s late", late("sun", 1.0)),
    "magnetometer's scale": Kind(
        r"mag\.scale_factor is ", spoil=sized("mag", faults.scaled, 0.003, 0.05)
    ),
    "soft iron": Kind(r"mag\.nonorthogonality is ", spoil=sized("mag", faults.sheared, 0.2, 4.0)),
    "gyro's scale": Kind(
        r"gyro\.(scale_factor|nonorthogonality) is ", spoil=sized("gyro", faults.scaled, 6e-3, 0.1)
    ),
    "step of the magnetometer": Kind("mag" + CHANGES, spoil=sized("mag", faults.stepped, 200, 5e3)),
    "step of the Sun sensor": Kind("sun" + CHANGES, spoil=sized("sun", faults.stepped, 0.01, 0.1)),
    "step of the gyro": Kind(DRIFTS, spoil=sized("gyro", faults.stepped, 4e-3, 0.1)),
    "drift of the magnetometer": Kind("mag" + CHANGES, spoil=sized("mag", faults.ramp, 300, 5e3)),
    "drift of the gyro": Kind(DRIFTS, spoil=sized("gyro", faults.ramp, 6e-3, 0.1)),
    "temperature": Kind("mag" + CHANGES, spoil=sized("mag", faults.warmed, 300, 5e3)),
    "asymmetry of the gyro": Kind(
        r"gyro\.(scale_asymmetry|scale_factor) is ",
        spoil=sized("gyro", faults.asymmetric, 6e-3, 0.05),
    ),
    "misalignment and temperature": Kind(
        r"mag\.(misalignment|bias) follows temperature by |mag\.bias changes",
        spoil=sized("mag", faults.bent, 0.5, 5.0),
    ),
    "torquers": Kind(r"mag(\.bias follows coil_x by | at .* bias_sensitivities)", spoil=torqued),
    "orbit": Kind(
        "(the satellite is .* its orbit|mag at .* correct epoch and orbit)",
        lambda rng: Craft(behind=sign(rng) * np.exp(rng.uniform(np.log(3.0), np.log(900.0)))),
    ),
    # what is seen without any attitude
    "magnetometer frozen": Kind("mag at .*equal samples", spoil=sensor("mag", held(0.1, 0.5))),
    "Sun sensor frozen": Kind("sun at .*equal samples", spoil=sensor("sun", held(0.1, 0.5))),
    "gyro frozen": Kind("gyro at .*equal samples", spoil=gyro(held(0.1, 0.5))),
    **{name: Kind(cause, spoil=spoil) for name, (cause, spoil) in faults.GROSS.items()},
    "ITRF": Kind("position at .* look like ITRF", spoil=in_itrf),
    "days since 1970": Kind("time at .* declare time_epoch", spoil=days_since(1970, 1, 1)),
    "hours": Kind("time at .* declare .*time_unit", spoil=shifted(lambda t, rng: t / 3600.0)),
    "magnetometer 90 deg off": Kind(
        "mag" + AXES.format("mag"), spoil=sensor("mag", rows_of(turned))
    ),
    "Sun sensor 90 deg off": Kind("sun" + AXES.format("sun"), spoil=sensor("sun", rows_of(turned))),
    "unit vectors": Kind(
        'sun: .*Use kind = "two-axis-sun-sensor" instead of', lambda rng: Craft(unit_vectors=True)
    ),
    "magnetometer in uT": Kind(
        "mag at .* unit = 'uT'", spoil=sensor("mag", lambda t, rows, rng: 1e-3 * rows)
    ),
    "quaternion scalar first": Kind(
        "tracker: .*read as scalar first", spoil=quaternions(lambda q: q[:, [3, 0, 1, 2]]),
        scenario=TRACKED,
    ),
    "quaternion conjugated": Kind(
        "tracker: .*read as from the body", spoil=quaternions(lambda q: q * [-1, -1, -1, 1]),
        scenario=TRACKED,
    ),
}  # fmt: skip


def run_case(number: int, name: str | None = None) -> Result:
    """Fly and calibrate a case, of a kind that follows from its number unless it is given."""
    name = name or list(KINDS)[number % len(KINDS)]  # as many of each
    kind = KINDS[name]
    telemetry = kind.fly(np.random.default_rng([SEED, number]))
    try:
        found = calibrate(kind.scenario, telemetry)
    except ValueError as error:
        return _told(number, name, str(error))
    if not found.is_consistent:
        return _told(number, name, found.failures[0])
    _, z = normalized(found, telemetry)
    off = float(np.abs(z[3:]).max())
    doubts = [note for note in found.notes if kind.cause and faults.says(kind.cause, note)]
    if off >= CHANCE and doubts:  # it may be so, telemetry cannot tell
        return Result(number, name, "named", doubts[0])
    return Result(number, name, "right" if off < CHANCE else "silent", f"off by {off:.1f} sigma")


def _told(number: int, name: str, line: str) -> Result:
    cause = KINDS[name].cause
    right = bool(cause) and faults.says(cause, line)
    return Result(number, name, "named" if right else "another cause", line)


def main() -> None:
    """Make the cases, print those that are not as they should be, and count outcomes by kind."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=len(KINDS), help="how many")
    parser.add_argument("--jobs", type=int, default=1)
    given = parser.parse_args()
    with ProcessPoolExecutor(given.jobs) as pool:
        results = list(pool.map(run_case, range(given.cases), chunksize=4))
    for result in results:
        if result.outcome in ("another cause", "silent"):
            print(f"{result.number:5} {result.kind}: {result.outcome}: {result.said[:150]}")
    counts = pd.crosstab([each.kind for each in results], [each.outcome for each in results])
    print(counts.to_string())
    told = counts.sum().reindex(["named", "another cause"], fill_value=0)
    print(f"cause named right: {told['named'] / max(told.sum(), 1):.1%} of those told to be wrong")


if __name__ == "__main__":
    main()
