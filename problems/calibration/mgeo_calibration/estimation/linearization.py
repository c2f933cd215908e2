"""Equations of some samples at once, linear in the errors of a trajectory."""

from __future__ import annotations

from dataclasses import dataclass

from mgeo_attitude._typing import Floats

from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.estimation.kinematics import Steps, steps, turns
from mgeo_calibration.estimation.sightings import Sightings, sightings
from mgeo_calibration.estimation.trajectory import Partition, Trajectory


@dataclass(frozen=True, eq=False)
class Equations:
    """Those of samples low to high - 1 of a batch.

    Attributes
    ----------
    low, high : int
    batch : Batch
        Of these samples.
    trajectory : Trajectory
        At these samples.
    parts : Partition
    steps : Steps
    sightings : Sightings
    """

    low: int
    high: int
    batch: Batch
    trajectory: Trajectory
    parts: Partition
    steps: Steps
    sightings: Sightings


def equations(
    batch: Batch, at: Trajectory, parts: Partition, growth: Floats, low: int, high: int
) -> Equations:
    """Of samples low to high - 1, with the growth of constants at all samples, shape (N, c)."""
    own, here = batch.part(low, high), at.part(low, high)
    turned = turns(own, here.states)
    move = steps(own, here, parts, growth[low:high], turned)
    return Equations(low, high, own, here, parts, move, sightings(own, here, parts, turned[0]))
