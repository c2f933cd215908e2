"""Readings that are none, or not what the scenario says: lengths, units, orders of quaternions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.sensors.direction_sensors import TwoAxisSunSensor
from mgeo_attitude.sensors.vector_sensors import SunSensor
from scipy.spatial.transform import Rotation

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.start import accumulated, carried_for, directions, wahba

#: Times the scatter of its sensor by which a vector is too long or too short.
_FAR = 20.0
#: Lengths that scatter by less than this share of the noise are those of normalized vectors.
_NORMALIZED = 0.05
_FEWEST = 10  # vectors, or samples, that can tell
_NORMAL = 1.4826  # 1-sigma of normal numbers over their median absolute deviation
#: What four numbers may be by mistake: in words, which of them are (x, y, z, scalar), and whether
#: the rotation is the inverse.
ORDERS = (
    ("scalar first", (1, 2, 3, 0), False),
    ("from the body to GCRF", (0, 1, 2, 3), True),
    ("scalar first, from the body to GCRF", (1, 2, 3, 0), True),
)
_BETTER = 0.1  # an order or unit is called wrong if another leaves this share of what disagrees
_CHECKED = 300  # samples that are looked at, at most
_ASTRAY = 0.5  # by how much the gyro's bias may turn the attitude in these, 1-sigma [rad]


def implausible(batch: Batch) -> Bools:
    """Vectors whose lengths stand apart from all others of their sensor, shape (s, N).

    Lengths need no attitude. A bias changes them less than they scatter, or all of them alike.
    """
    found = np.zeros((len(batch.sensors), len(batch.times)), dtype=bool)
    for index, rows in enumerate(batch.sensors):
        seen = np.isfinite(rows[:, 0, 0])
        if rows.shape[1:] != (1, 3) or not seen.any():
            continue
        off = _length(rows[seen, 0]) - _length(batch.vectors[seen, index])
        off -= np.median(off)
        scatter = max(_NORMAL * float(np.median(np.abs(off))), float(batch.noise[index].max()))
        found[index, seen] = np.abs(off) > _FAR * scatter
    return found


def check_normalized(batch: Batch) -> None:
    """Refuse vectors to the Sun that are directions where three noisy numbers are expected.

    Raises
    ------
    ValueError
        Naming the kind of sensor that they are of.
    """
    for sensor, rows in zip(batch.suite.sensors, batch.sensors, strict=True):
        seen = np.isfinite(rows[:, 0, 0])
        if not isinstance(sensor, SunSensor) or sensor.unit_length or seen.sum() < _FEWEST:
            continue
        length, noise = _length(rows[seen, 0]), min(sensor.noise())
        scatter = float(np.median(np.abs(length - np.median(length))))
        if scatter < _NORMALIZED * noise:
            raise ValueError(
                f"{sensor.name}: the lengths of its vectors scatter by {scatter:.2g}, where noise "
                f"of {noise:.2g} along each axis is expected: these are directions, of two numbers "
                f'each. Expected kind = "{TwoAxisSunSensor.kind}", not "{sensor.kind}"'
            )


def _length(vectors: Floats) -> Floats:
    with np.errstate(over="ignore"):
        length: Floats = np.linalg.norm(vectors, axis=1)
    return length


def check_orders(batch: Batch, where: slice, belief: Belief) -> None:
    """Refuse quaternions that agree with all else if they are read in another way.

    Attitudes that are wrong alike may agree with each other; so what counts is the sensor that
    agrees least with one attitude, carried by the gyro. Nothing is found of a tracker that was
    mounted otherwise than along the body axes.

    Parameters
    ----------
    where : slice
        Samples among which the vectors are far apart, see `start.stretch`.
    belief : Belief
        What is known of the gyro's bias.

    Raises
    ------
    ValueError
        Naming the sensor, and how its quaternions are to be read.
    """
    trackers = [i for i, rows in enumerate(batch.sensors) if rows.shape[1] == 3]
    if not trackers:
        return
    part, states = checked(batch, where, belief)
    relative = accumulated(part, states)
    found = _disagreement(part, relative, states)
    for i in trackers:
        for words, order, inverse in ORDERS:
            sensors = list(part.sensors)
            sensors[i] = reread(sensors[i], order, inverse)
            other = replace(part, sensors=tuple(sensors))
            if _disagreement(other, relative, states) < _BETTER * found:
                raise ValueError(
                    f"{batch.suite.sensors[i].name}: its quaternions agree with gyro and other "
                    f"sensors if they are read as {words}: expected scalar last, from GCRF to the "
                    "body"
                )


def reread(axes: Floats, order: tuple[int, ...], inverse: bool) -> Floats:
    """Axes, shape (n, 3, 3), of the same quaternions with their numbers in another order."""
    found = np.full_like(axes, np.nan)
    there = np.isfinite(axes).all(axis=(1, 2))
    rotations = Rotation.from_quat(Rotation.from_matrix(axes[there]).as_quat()[:, order])
    found[there] = (rotations.inv() if inverse else rotations).as_matrix()
    return found


def _disagreement(batch: Batch, relative: Floats, states: Floats) -> float:
    """Median square residual of the sensor that agrees least with one attitude."""
    seen = directions(batch, relative, states)
    rotation, _ = wahba(seen, np.ones(len(seen.samples), dtype=bool))
    square = ((seen.inertial - seen.body @ rotation.T) ** 2).sum(axis=1)
    return max(float(np.median(square[seen.sensor == one])) for one in np.unique(seen.sensor))


def checked(batch: Batch, where: slice, belief: Belief) -> tuple[Batch, Floats]:
    """Samples about a stretch over which the gyro can be believed, and their prior states."""
    middle = (where.start + where.stop) // 2
    half = min(_CHECKED, max(_FEWEST, carried_for(batch, belief.sigma[3:6], _ASTRAY))) // 2
    part = batch.part(max(0, middle - half), min(len(batch.times), middle + half))
    return part, np.tile(belief.states, (len(part.times), 1))
