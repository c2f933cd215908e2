"""The scenario: everything a run of the filter depends on, checked as a whole."""

from __future__ import annotations

import dataclasses
import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo.store.atomic import write_file
from mgeo_attitude._typing import Floats
from mgeo_attitude.criteria.objectives import OBJECTIVES, PAPER, TRACE_OF
from mgeo_attitude.environment.directions import Place
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.environment.orbit import ORBITS, AnyOrbit
from mgeo_attitude.environment.times import instant_after
from mgeo_attitude.maneuvers.schedule import Turning
from mgeo_attitude.scenario.actuators import Coils, Wheels, assumed, slew_limits
from mgeo_attitude.scenario.after import going_on
from mgeo_attitude.scenario.channels import Channel
from mgeo_attitude.scenario.goals import (
    Convergence,
    FlightErrors,
    RequiredSigma,
    TraceWeights,
    check_blocks,
    check_objectives,
)
from mgeo_attitude.scenario.initial import InitialConditions
from mgeo_attitude.scenario.limits import ManeuverLimits, PathLimit, Window, deadline
from mgeo_attitude.scenario.prior import Prior
from mgeo_attitude.scenario.toml import ScenarioFileError, on_preset, read_toml, to_toml
from mgeo_attitude.scenario.validity import Implausible, check_together, implausible
from mgeo_attitude.sensors import SENSORS
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.sensors.world import World
from mgeo_attitude.settings.base import Kinds, Settings, to_table
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_attitude.settings.types import Instant, Line, Seconds

_NO_GYRO = (
    "expected a table of its keys: the filter needs a gyro, see 'Without a gyro' in docs/errors.md"
)


@dataclass(frozen=True, kw_only=True)
class Scenario(Settings):
    """Orbit, instruments, limits and criteria of one study; frozen, hashable and picklable.

    An epoch with another UTC offset is converted to UTC; a naive one is refused.

    Raises
    ------
    InvalidValue
        (ValueError) Naming the key, its value and what was expected.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> scenario = Scenario.from_dict({"preset": "cubesat_6u", "duration": 5400.0})
    >>> scenario.save("mine.toml")
    >>> Scenario.from_toml("mine.toml") == scenario
    True
    """

    name: Line = "custom"
    """name of the scenario, on one line"""
    epoch: Instant
    """start of the run with its UTC offset; Z is UTC"""
    duration: Seconds = Field(gt=0.0)
    """longest time to converge, a multiple of the step; a slew back may end later"""
    step: Seconds = Field(default=1.0, gt=0.0)
    """time step of the filter"""
    eclipse: bool = True
    """whether the Earth's shadow blinds the Sun sensors"""
    objectives: tuple[str, ...] = Field(
        default=PAPER,
        min_length=1,
        description=f"what to minimize, of {', '.join(OBJECTIVES)}, {TRACE_OF}BLOCK,BLOCK...",
    )
    orbit: Annotated[AnyOrbit, ORBITS]
    """elements at the epoch, an element set, or an ephemeris"""
    gyro: Gyro = Field(default_factory=Gyro)
    """three-axis gyro"""
    sensors: tuple[Annotated[Sensor, Kinds("kind", SENSORS)], ...] = Field(min_length=1)
    """sensors, at least one, each with its own name"""
    world: World = Field(default_factory=World)
    """errors of field, orbit and light from the Earth, shared by all sensors"""
    channels: tuple[Channel, ...] = ()
    """what something else on board will measure, which biases follow"""
    initial: InitialConditions = Field(default_factory=InitialConditions)
    """attitude and body rate at the start, and what is known of it"""
    maneuvers: ManeuverLimits = Field(default_factory=ManeuverLimits)
    """bounds of the design vector"""
    convergence: Convergence = Field(default_factory=Convergence)
    """when the filter counts as converged"""
    trace_weights: Annotated[Mapping[str, float], TraceWeights] = Field(
        default_factory=TraceWeights
    )
    """weight of each state block in the trace; where none is given 1, but 0 for errors that vary or
    are considered"""
    required_sigma: Annotated[Mapping[str, float], RequiredSigma] = Field(
        default_factory=RequiredSigma
    )
    """1-sigma that each axis of a state block must reach, by key with unit"""
    wheels: Wheels | None = None
    """reaction wheels that turn the satellite"""
    coils: Coils | None = None
    """magnetic coils; without wheels they turn it"""
    path_limits: tuple[PathLimit, ...] = ()
    """cones that a direction must stay out of, or in, along the way"""
    windows: tuple[Window, ...] = ()
    """times in which a plan may be flown from start to end; none is any time"""
    flight: FlightErrors | None = None
    """flights over which plans are judged; without it each is flown exactly"""
    prior: Prior | None = None
    """what a calibration has found, in place of initial attitude, rate and 1-sigmas"""

    def __post_init__(self) -> None:
        units = self.suite.units
        check_together(self, self.suite)
        try:
            orbit = self.orbit.for_run(self.epoch, self.latest_end)
            object.__setattr__(self, "orbit", orbit)
        except InvalidValue as error:
            raise error.under("orbit") from None
        check_blocks("trace_weights", self.trace_weights, units)
        keys = [unit.key(block) for block, unit in units.items()]
        check_blocks("required_sigma", self.required_sigma, keys)
        check_objectives(self.objectives, units, bool(self.required_sigma))

    @property
    def suite(self) -> Suite:
        """Gyro, sampled at every step, sensors and world as one error state."""
        return Suite(self.gyro.sampled(self.step), self.sensors, self.world)

    @property
    def n_steps(self) -> int:
        """Number of steps of the whole duration."""
        return round(self.duration / self.step)

    @property
    def deadline(self) -> float:
        """When a plan has to be over, slew back included [s]; infinite without windows.

        It is over even if it begins as late as the flights that it is judged over.
        """
        return deadline(self)

    @property
    def latest_end(self) -> float:
        """When the last of its runs ends [s]: of one that begins with the longest delay."""
        return self.duration + (0.0 if self.flight is None else self.flight.start_delay)

    def starting(self, time: float) -> Scenario:
        """Return the scenario with its epoch moved by a time [s], on the same orbit."""
        epoch = instant_after(self.epoch, time)
        return dataclasses.replace(self, epoch=epoch, orbit=self.orbit.later(time))

    @property
    def turned_by_coils(self) -> bool:
        """Whether it has coils and no wheels."""
        return self.coils is not None and self.wheels is None

    def turning(self, field: Floats, attitude: Floats, rate: Floats) -> Turning:
        """What turns it from an attitude and a rate, with coils along a field [T], GCRS."""
        if self.coils is not None and self.turned_by_coils:
            return self.coils.drive(field, attitude, rate)
        return slew_limits(self.maneuvers, self.wheels, rate)

    @property
    def needs_field(self) -> bool:
        """Whether anything on board follows from the geomagnetic field."""
        dipole = self.wheels is not None and any(self.wheels.residual_dipole)
        dipole |= self.coils is not None and self.coils.unloads
        return dipole or self.turned_by_coils or any(each.needs_field for each in self.sensors)

    @property
    def assumed(self) -> tuple[str, ...]:
        """What is taken for granted of how the satellite turns, each in a line."""
        return assumed(self.wheels, self.coils)

    @property
    def times(self) -> Floats:
        """Sample times k * step since the epoch [s], shape (n_steps + 1,)."""
        return self.step * np.arange(self.n_steps + 1, dtype=np.float64)

    def initial_attitude(self, at: Environment | Place) -> Floats:
        """GCRS to body at the epoch, of which `at` is; shape (3, 3)."""
        return self.initial.attitude(at)[0] if self.prior is None else self.prior.attitude

    def initial_rate(self, at: Environment | Place) -> Floats:
        """Body rate at the epoch [rad/s], shape (3,)."""
        return self.initial.rate(at) if self.prior is None else self.prior.rate

    @property
    def initial_attitude_covariance(self) -> Floats:
        """Of the attitude error at the epoch [rad²], shape (3, 3)."""
        if self.prior is None:
            return float(np.radians(self.initial.attitude_deg)) ** 2 * np.eye(3)
        return np.array(self.prior.covariance)[:3, :3]

    @staticmethod
    def paper() -> Scenario:
        """Table 2 of Hott, Chagas & de Sousa; what it leaves open reproduces its fronts.

        Its file, ``scenario/paper.toml``, says which values are ours.
        """
        return Scenario.from_dict({"preset": "paper"})

    @staticmethod
    def cubesat_1u() -> Scenario:
        """A cubesat of one unit that coils alone turn; its file says where its figures are from."""
        return Scenario.from_dict({"preset": "cubesat_1u"})

    @staticmethod
    def microsatellite() -> Scenario:
        """110 kg with two star trackers and wheels; its file says where its figures are from."""
        return Scenario.from_dict({"preset": "microsatellite"})

    @staticmethod
    def cubesat_6u() -> Scenario:
        """A 6U cubesat with small instruments, in the paper's orbit with its eclipses.

        By the rule "trace" it would count as converged later than the paper's satellite: below
        1 % over 300 s.
        """
        return Scenario.from_dict({"preset": "cubesat_6u"})

    @staticmethod
    def cubesat_6u_full() -> Scenario:
        """`cubesat_6u` with every error of its instruments and models, constant or varying.

        Its file, ``scenario/cubesat_6u_full.toml``, says where they are from.
        """
        return Scenario.from_dict({"preset": "cubesat_6u_full"})

    def to_dict(self) -> dict[str, Any]:
        """The scenario as nested dicts and lists of JSON's types; see `from_dict`."""
        table = to_table(self)
        if self.objectives == PAPER:  # they go without saying
            del table["objectives"]
        return table

    @staticmethod
    def from_dict(table: Mapping[str, Any], folder: str | os.PathLike[str] = "") -> Scenario:
        """Inverse of `to_dict`; ``preset`` names a preset that `table` overrides key by key.

        Or it overrides the scenario that goes on from the calibration whose document is ``after``:
        from its attitude, time and covariance, see `Calibration.scenario_after`.

        A list of sensors replaces the preset's. What one of them leaves out is that of the preset's
        sensor of the same name and kind, or else of its only one of the kind, or else the kind's
        default. An orbit is read from the file that ``orbit.file`` names in `folder`.

        Raises
        ------
        InvalidValue
            Naming the full key (``orbit.eccentricity``): unknown, missing or of a bad value.
        """
        if not isinstance(table.get("gyro", {}), Mapping):
            raise InvalidValue("gyro", table["gyro"], _NO_GYRO)
        if "after" in table:
            table = going_on(table, Scenario.from_dict)
        return Scenario(**_in_folder(on_preset(table), folder))

    def to_toml(self) -> str:
        """The scenario as a TOML document with a comment on every key."""
        units = self.suite.units
        keys = {
            "trace_weights": units,
            "required_sigma": [unit.key(block) for block, unit in units.items()],
        }
        notes = {key: f"The blocks: {', '.join(blocks)}" for key, blocks in keys.items()}
        return to_toml(self, self.to_dict(), notes)

    @staticmethod
    def from_toml(source: str | os.PathLike[str]) -> Scenario:
        """Read a TOML file, or TOML text; ``preset = "..."`` works as in `from_dict`.

        An orbit's file that it names is read from its own folder.

        Parameters
        ----------
        source : path or str
            A path object, or a one-line string ending in ``.toml``, is a file; any other string
            is the text itself.

        Raises
        ------
        ScenarioFileError
            (ValueError) Naming the file and the key, or the line where it is no TOML.

        Warns
        -----
        Implausible
            Of what looks like a slip; see `implausible`.
        """
        origin, folder, table = read_toml(source)
        try:
            scenario = Scenario.from_dict(table, folder)
        except ValueError as error:
            raise ScenarioFileError(f"{origin}: {error}") from error
        for line in implausible(scenario):
            warnings.warn(f"{origin}: {line}", Implausible, stacklevel=2)
        return scenario

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write `to_toml` to a file, which is replaced as a whole or not at all."""
        write_file(Path(path), self.to_toml().encode())


def _in_folder(table: dict[str, Any], folder: str | os.PathLike[str]) -> dict[str, Any]:
    """The table with the full name of the orbit's file, if it names one."""
    orbit = table.get("orbit")
    if not isinstance(orbit, Mapping) or not isinstance(orbit.get("file"), str):
        return table
    return table | {"orbit": {**orbit, "file": os.path.join(folder, orbit["file"])}}
