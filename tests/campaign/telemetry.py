"""Telemetry that is not as it should be, and calibrations that somebody has edited."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_calibration import Calibration, Telemetry, TelemetryMapping, calibrate, fly
from mgeo_calibration.calibration.document import read_json, to_json
from mgeo_calibration.telemetry.files import parse_table
from mgeo_calibration.telemetry.reading import read_telemetry

from mgeo.store.scenario_file import read_scenario

from .harness import Attempt, Box, kind
from .mutations import spoiled_bytes, spoiled_table
from .run_folders import spoil_json
from .texts import spoiled_toml

PLAN = [0.5, 0.3, -0.2, 80.0, -0.3, 0.6, 0.2, 80.0, 0.2, -0.4, 0.7, 80.0]
MAPPING = """\
time = "time"
[gyro]
columns = ["gyro_x", "gyro_y", "gyro_z"]
unit = "deg/s"
rate = "mean"
range_deg_s = 10.0
dcm = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
[[sensors]]
name = "mag"
unit = "nT"
quaternion = [0.0, 0.0, 0.0, 1.0]
"""


@cache
def scenario() -> Scenario:
    return Scenario.from_toml('preset = "paper"\nduration = 240.0\nconvergence.window = 100.0\n')


@cache
def flight() -> Telemetry:
    return fly(scenario(), PLAN, 1)


@cache
def calibrated() -> str:
    return to_json(calibrate(scenario(), flight()))


def written(frame: pd.DataFrame) -> bytes:
    text: str = frame.to_csv(index=False, lineterminator="\n")
    return text.encode()


def _with_units(text: str) -> str:
    names, rows = text.split("\n", 1)
    units = ["s" if name == "time" else "-" for name in names.split(",")]
    return f"{names}\n{','.join(units)}\n{rows}"


#: As ground systems write a table of CSV.
_WRITTEN: dict[str, Callable[[str], bytes]] = {
    "as it is": str.encode,
    "decimal commas": lambda text: text.replace(",", ";").replace(".", ",").encode(),
    "tabs": lambda text: text.replace(",", "\t").encode(),
    "blanks": lambda text: text.replace(",", ", ").replace("\n", " \r\n").encode(),
    "separators at the ends": lambda text: text.replace("\n", ",\n").encode(),
    "gzip": lambda text: gzip.compress(text.encode(), mtime=0),
    "a row of units": lambda text: _with_units(text).encode(),
    "comments": lambda text: f"# pass 7\n\n{text}# end\n".encode(),
}


@kind(weight=6)
def telemetry_read(box: Box) -> Attempt:
    """Other cells, rows, columns or bytes, of files as ground systems write them."""
    content, how = written(flight().frame()), box.pick(list(_WRITTEN))
    box.note(how)
    plain = spoiled_table(box, content).decode() if box.chance(0.7) else None
    made = _WRITTEN[how](content.decode() if plain is None else plain)
    Path("t.csv").write_bytes(spoiled_bytes(box, made) if plain is None else made)

    def sound(found: Telemetry) -> None:
        others = [found.frame()] if plain is None else [found.frame(), parse_table(plain)]
        for other in others:
            again = read_telemetry(other, scenario())
            pd.testing.assert_frame_equal(again.frame(), found.frame(), check_exact=True)

    return Attempt(lambda: read_telemetry(Path("t.csv"), scenario()), ("t.csv",), sound=sound)


@kind(weight=3)
def telemetry_mapped(box: Box) -> Attempt:
    """A mapping that somebody has edited."""
    Path("t.csv").write_bytes(written(flight().frame()))
    spoiled_toml(box, Path("m.toml"), MAPPING)

    def action() -> Telemetry:
        return read_telemetry("t.csv", scenario(), TelemetryMapping.from_toml("m.toml"))

    return Attempt(action, ("m.toml", "t.csv"))


@kind(weight=3)
def telemetry_calibrated(box: Box) -> Attempt:
    """Numbers that are numbers, but not those of a flight."""
    frame = flight().frame()
    for _ in range(1 if box.chance(0.7) else 2):
        frame = _changed(box, frame)
    Path("t.csv").write_bytes(written(frame))

    def sound(found: Calibration) -> None:
        assert np.linalg.eigvalsh(found.covariance)[0] > 0.0
        assert np.isfinite(found.states).all()
        assert (found.table()["sigma"] <= 1.0001 * found.table()["prior_sigma"]).all()
        json.loads(to_json(found))

    return Attempt(lambda: calibrate(scenario(), Path("t.csv")), sound=sound)


@kind(weight=0.2)
def telemetry_command(box: Box) -> Attempt:
    frame = _changed(box, flight().frame())
    content = written(frame)
    Path("t.csv").write_bytes(spoiled_table(box, content) if box.chance(0.5) else content)
    scenario().save("s.toml")
    action = ["mgeo", "attitude", "calibrate", "t.csv", "--scenario", "s.toml", "--out", "o"]
    return Attempt(action, creates=("work/o/*",), codes=(0, 3))


@kind(weight=3)
def calibration_read(box: Box) -> Attempt:
    path = Path("calibration.json")
    path.write_text(calibrated())
    spoil_json(box, path)
    return Attempt(lambda: read_json(path), ("calibration.json",), sound=to_json)


@kind(weight=3)
def calibration_gone_on_from(box: Box) -> Attempt:
    """Another value in what the next scenario starts from."""
    path = Path("calibration.json")
    path.write_text(calibrated())
    spoil_json(box, path)

    def action() -> AttitudeManeuverProblem:
        options = read_scenario("attitude", None, after=path)
        return AttitudeManeuverProblem.from_options(options)

    def sound(problem: AttitudeManeuverProblem) -> None:
        again = Scenario.from_dict(problem.scenario.to_dict())
        assert again == problem.scenario
        assert np.linalg.eigvalsh(problem.model.initial_correlation)[0] > 0.0
        assert np.isfinite(problem.model.initial_states).all()

    return Attempt(action, sound=sound)


@kind(weight=0.2)
def calibration_command(box: Box) -> Attempt:
    path = Path("calibration.json")
    path.write_text(calibrated())
    spoil_json(box, path)
    return Attempt(["mgeo", "solve", "attitude", "--after", str(path), "--dry-run"])


def _changed(box: Box, frame: pd.DataFrame) -> pd.DataFrame:
    """In one of the ways of satellites, ground stations and their people."""
    columns = list(frame.columns[1:])
    one, name = box.pick(columns), box.pick(["gyro", "sun", "mag"])
    own = [column for column in columns if column.startswith(name)]
    n = len(frame)
    a, b = sorted(int(k) for k in box.rng.integers(0, n + 1, 2))
    changed = frame.copy()
    factor = box.pick([0.0, -1.0, 1e-9, 1e9, 1e300, np.pi / 180.0, 57.3, 3600.0, 1e-300])
    span, value = slice(a, b), float(frame[one].get(min(a, n - 1), 0.0))
    later = np.where(np.arange(n) >= a, box.pick([-50.0, 0.5, 1e4, 1e12, -1e12]), 0.0)
    slower = box.pick([-1.0, 0.0, 1e-9, 1e-3, 60.0, 1e6, 1e300])
    noise = box.rng.standard_normal((n, len(own)))
    changes: dict[str, Any] = {
        f"{name} times {factor}": lambda: changed.update(frame[own] * factor),
        f"{one} times {factor}": lambda: changed.update(frame[[one]] * factor),
        f"{name} nothing": lambda: changed.__setitem__(own, np.nan),
        f"{name} nothing from {a} to {b}": lambda: changed.loc.__setitem__((span, own), np.nan),
        f"{name} zero from {a} to {b}": lambda: changed.loc.__setitem__((span, own), 0.0),
        f"{one} stuck from {a} to {b}": lambda: changed.loc.__setitem__((span, one), value),
        f"{one} clipped": lambda: changed.__setitem__(one, frame[one].clip(upper=value)),
        f"{name} noise": lambda: changed.__setitem__(own, noise),
        f"time shifted from {a}": lambda: changed.__setitem__("time", frame["time"] + later),
        f"time times {slower}": lambda: changed.__setitem__("time", frame["time"] * slower),
    }
    chosen = box.pick(list(changes))
    box.note(chosen)
    changes[chosen]()
    if box.chance(0.2):
        box.note(f"rows {a} to {b} only")
        changed = changed[a:b].reset_index(drop=True)
    if box.chance(0.1):
        changed = changed.sample(frac=1.0, random_state=0, ignore_index=True)
    return changed
