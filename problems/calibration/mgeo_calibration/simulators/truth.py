"""JSON documents with the true attitude and the true errors at the end of a simulated run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from mgeo_attitude.environment.times import seconds_between
from mgeo_attitude.geometry.quaternion import quaternions_from_matrices
from mgeo_attitude.plan.documents import parse_document, read_document, read_scenario
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.scenario.prior import check_quaternion, read_states
from mgeo_attitude.settings.errors import expect
from scipy.spatial.transform import Rotation

from mgeo.validation.entries import get_entry
from mgeo_calibration.calibration.corrections import convert_block
from mgeo_calibration.telemetry.telemetry import Telemetry, Truth

if TYPE_CHECKING:
    from mgeo_calibration.documents import TruthFile

FORMAT = "mgeo-attitude-truth"
VERSION = 1

#: Largest difference between the end of a run and the epoch of a follow-up plan [s].
_MAX_TIME_DIFFERENCE = 1e-3


def read_truth(path: Path, plan: ManeuverPlan) -> Truth:
    """Read the true attitude and states at the end of an earlier run from a JSON file. The run of a
    follow-up plan starts with them.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError, TypeError
        With the file and the key, if the file contains no truth, or if satellite or time do not
        match.
    """
    return read_document(path, lambda text: _parse_truth(text, plan))


def _parse_truth(text: str, plan: ManeuverPlan) -> Truth:
    table = parse_document(text, FORMAT, VERSION)
    before = read_scenario(table)
    get_entry(table, "states", dict)
    states = read_states(table, plan.scenario.suite)
    rows = [get_entry(states, block, list[float], "states.") for block in states]
    expect({len(row) for row in rows} == {3}, "states", states, "three numbers each")
    quaternion = get_entry(table, "quaternion", list[float])
    check_quaternion(quaternion)
    time = float(get_entry(table, "time_s", float))
    gap = seconds_between(before.epoch, plan.scenario.epoch) - time
    start = f"the epoch of the plan, {time + gap:.6f} s after {before.epoch.isoformat()}"
    expect(abs(gap) < _MAX_TIME_DIFFERENCE, "time_s", time, start)
    attitude = Rotation.from_quat(quaternion).as_matrix().T
    return Truth(attitude=attitude[None], states=np.concatenate([np.zeros(3), *rows])[None])


def build_truth_document(
    plan: ManeuverPlan, telemetry: Telemetry, simulator: str, seed: int
) -> TruthFile:
    """Return the true attitude and states at the last sample as a JSON-serializable dict with the
    keys of ``calibration.json``.

    ``parameters`` has the column ``value`` instead of ``estimate``.
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
        "quaternion": quaternions_from_matrices(telemetry.truth.attitude[-1:])[0].tolist(),
        "states": dict(zip(suite.blocks[1:], states.reshape(-1, 3)[1:].tolist(), strict=True)),
        "parameters": [
            {"block": block, "axis": axis, "unit": suite.units[block].text, "value": float(value)}
            for block in suite.blocks[1:]
            for axis, value in zip("xyz", convert_block(suite, states, block), strict=True)
        ],
    }
