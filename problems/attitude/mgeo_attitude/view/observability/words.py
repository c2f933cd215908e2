"""A direction of the error state in an engineer's words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.suite import Suite, block_units

#: Share of the squared direction, in initial sigmas, from which a 3-vector is worth a word.
_SHARE = 0.1
#: Rotations count as alike if they differ by less than this fraction of the first one.
_ALIKE = 0.4
#: A vector within 15 degrees of a body axis is named after it.
_ON_AXIS = np.cos(np.radians(15.0))


def in_words(suite: Suite, initial_sigma: Floats, direction: Floats) -> str:
    """Name a direction, such as ``common rotation of attitude and both sensors about body z``.

    Sensors that are rotated alike are named together, with the attitude if it turns with them: that
    is what vectors measured in body axes cannot see by themselves. The rest follows by its share.

    Parameters
    ----------
    initial_sigma : array, shape (n_states,)
        1-sigma of every state at the start, in the filter's units.
    direction : array, shape (n_states,)
        Not zero, every state in units of its initial 1-sigma; its sign means nothing.
    """
    blocks = dict(zip(suite.blocks, block_units(suite), strict=True))
    share = (direction.reshape(-1, 3) ** 2).sum(axis=1) / (direction @ direction)
    vector = dict(zip(blocks, (direction * initial_sigma).reshape(-1, 3), strict=True))
    order = np.argsort(-share, kind="stable")
    least = min(_SHARE, share[order[0]])
    named = [suite.blocks[i] for i in order if share[i] >= least]
    # the gyro's misalignment turns with its rates, not with vectors
    sensors = [f"{sensor.name}.misalignment" for sensor in suite.sensors]
    sensors = [name for name in sensors if name in blocks]
    together = _rotated_alike(sensors, named, vector)
    rest = [name for name in named if name not in together]
    first = vector[(together or rest)[0]]
    sign = np.sign(first[np.argmax(np.abs(first))])
    phrases = []
    if together:
        mean = sign * np.mean([vector[name] for name in together], axis=0)
        phrases = [f"common rotation of {_joined(together, len(sensors))} about {_axis(mean)}"]
    for name in rest:
        turns = name.endswith(("attitude", ".misalignment")) or name == "gyro.bias"
        where = f"{'about' if turns else 'along'} {_axis(sign * vector[name])}"
        phrases.append(f"{blocks[name].label} {where}")
    return " with ".join(phrases)


def _rotated_alike(
    sensors: Sequence[str], named: Sequence[str], vector: dict[str, Floats]
) -> list[str]:
    """What turns like the most prominent misalignment: sensors and attitude, or nothing else."""
    tilts = [vector[name] for name in named if name in sensors]
    if not tilts:
        return []
    alike = [
        name
        for name in ("attitude", *sensors)
        if np.linalg.norm(vector[name] - tilts[0]) < _ALIKE * np.linalg.norm(tilts[0])
    ]
    return alike if len(alike) > 1 else []


def _joined(names: Sequence[str], every: int) -> str:
    """``attitude and both sensors``, or names of sensors, `every` of which there are."""
    sensors = [name.partition(".")[0] for name in names if name != "attitude"]
    if len(sensors) == every > 1:
        text = "both sensors" if every == 2 else f"all {every} sensors"
    else:
        text = " and ".join(sensors)
    return f"attitude and {text}" if "attitude" in names else text


def _axis(vector: Floats) -> str:
    unit = vector / np.linalg.norm(vector)
    largest = int(np.argmax(np.abs(unit)))
    if abs(unit[largest]) >= _ON_AXIS:
        return f"body {'-' if unit[largest] < 0.0 else ''}{'xyz'[largest]}"
    # adding zero makes -0.00 a 0.00
    return f"body ({', '.join(f'{component:.2f}' for component in unit.round(2) + 0.0)})"
