"""Blocks of the error state of gyro and sensors: units, and which vary or are considered."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from mgeo_attitude.fields.units import DEG, DIMENSIONLESS, Unit
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.markov import GaussMarkov


def state_units(gyro: Gyro, sensors: Iterable[Sensor]) -> dict[str, Unit]:
    """Unit of each 3-vector of the error state for people and scenario files, by its name."""
    owners: dict[str, Gyro | Sensor] = {"gyro": gyro} | {sensor.name: sensor for sensor in sensors}
    units = {
        f"{name}.{state}": owner.units.get(state, DIMENSIONLESS)
        for name, owner in owners.items()
        for state in owner.states()
    }
    varying, own = processes(owners.values()), [f"gyro.{state}" for state in gyro.states()]
    first = {block: units[block] for block in (*own, *varying)}  # the filter has them before others
    return {"attitude": DEG} | first | units


def processes(owners: Iterable[Gyro | Sensor]) -> dict[str, GaussMarkov]:
    """States of sensors that are Gauss-Markov processes, by the names of their blocks."""
    return {
        f"{owner.name}.{state}": value
        for owner in owners
        if isinstance(owner, Sensor)
        for state, value in owner.states().items()
        if isinstance(value, GaussMarkov)
    }


def considered_blocks(gyro: Gyro, sensors: Iterable[Sensor]) -> tuple[str, ...]:
    """Blocks of the state that are considered, not estimated."""
    own = [f"gyro.{state}" for state in gyro.considered]
    return (*own, *(f"{each.name}.{state}" for each in sensors for state in each.considered))


def uncalibrated(gyro: Gyro, sensors: Sequence[Sensor]) -> frozenset[str]:
    """Blocks of the state that no plan makes smaller for good: they vary, or are considered."""
    return frozenset((*processes(sensors), *considered_blocks(gyro, sensors)))
