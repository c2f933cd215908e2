"""Scenario: all inputs of a maneuver optimization, checked for consistency."""

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
from mgeo_attitude.criteria.objectives import OBJECTIVES, PAPER_OBJECTIVES, TRACE_PREFIX
from mgeo_attitude.environment.directions import SatelliteState
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.environment.orbit import ORBITS, AnyOrbit
from mgeo_attitude.environment.times import instant_after
from mgeo_attitude.maneuvers.schedule import RotationDynamics
from mgeo_attitude.scenario.actuators import (
    Magnetorquers,
    Wheels,
    build_slew_limits,
    list_assumptions,
)
from mgeo_attitude.scenario.constraints import (
    ManeuverBounds,
    PathConstraint,
    Window,
    compute_deadline,
)
from mgeo_attitude.scenario.continuation import continue_scenario
from mgeo_attitude.scenario.criteria import (
    Convergence,
    MonteCarloSettings,
    RequiredSigma,
    TraceWeights,
    check_blocks,
    check_objectives,
)
from mgeo_attitude.scenario.housekeeping import HousekeepingChannel
from mgeo_attitude.scenario.initial_conditions import InitialConditions
from mgeo_attitude.scenario.prior import Prior
from mgeo_attitude.scenario.toml import ScenarioFileError, merge_preset, read_toml, to_toml
from mgeo_attitude.scenario.validity import (
    ImplausibleValue,
    check_consistency,
    find_implausible_values,
)
from mgeo_attitude.sensors import SENSORS
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.environment_errors import EnvironmentErrors
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.settings.base import Settings, TableClasses, to_table
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_attitude.settings.types import DisplayName, Instant, Seconds

_NO_GYRO = "expected a [gyro] table: the filter needs a gyro, see docs/how-to/describe-sensors.md"


@dataclass(frozen=True, kw_only=True)
class Scenario(Settings):
    """Immutable, hashable definition of a maneuver optimization.

    A scenario specifies orbit, gyro, sensors, constraints and criteria. An epoch with another UTC
    offset is converted to UTC; an epoch without offset is rejected.

    Raises
    ------
    InvalidValue
        (ValueError) If a field is invalid; the message names the key, its value and the expected
        values.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> scenario = Scenario.from_dict({"preset": "cubesat_6u", "duration": 5400.0})
    >>> scenario.save("mine.toml")
    >>> Scenario.from_toml("mine.toml") == scenario
    True
    """

    name: DisplayName = "custom"
    """name of the scenario for display, on one line"""
    epoch: Instant
    """start of the plan, with its UTC offset; Z is UTC"""
    duration: Seconds = Field(gt=0.0)
    """latest t_end of a plan, a multiple of the step; a slew back may end later"""
    step: Seconds = Field(default=1.0, gt=0.0)
    """time step of the filter"""
    eclipse: bool = True
    """true if eclipses interrupt the measurements of Sun sensors and photodiodes"""
    objectives: tuple[str, ...] = Field(
        default=PAPER_OBJECTIVES,
        min_length=1,
        description="objectives, which are minimized: one or more of "
        f"{', '.join(OBJECTIVES)}, {TRACE_PREFIX}BLOCK,BLOCK...",
    )
    orbit: Annotated[AnyOrbit, ORBITS]
    """elements at the epoch, an element set, or an ephemeris"""
    gyro: Gyro = Field(default_factory=Gyro)
    """three-axis gyro"""
    sensors: tuple[Annotated[Sensor, TableClasses("kind", SENSORS)], ...] = Field(min_length=1)
    """sensors, at least one, with unique names"""
    environment_errors: EnvironmentErrors = Field(default_factory=EnvironmentErrors)
    """errors of the models of field, orbit and albedo, shared by all sensors"""
    housekeeping_channels: tuple[HousekeepingChannel, ...] = ()
    """predicted housekeeping channels on which biases depend"""
    initial: InitialConditions = Field(default_factory=InitialConditions)
    """initial attitude with its uncertainty, and initial body rate"""
    maneuvers: ManeuverBounds = Field(default_factory=ManeuverBounds)
    """number of maneuvers, and bounds on their rates and durations"""
    convergence: Convergence = Field(default_factory=Convergence)
    """rule that defines the end of a plan"""
    trace_weights: Annotated[Mapping[str, float], TraceWeights] = Field(
        default_factory=TraceWeights
    )
    """weight of each block of the error state in the trace; default: 1, or 0 for errors that vary
    with time or are considered but not estimated"""
    required_sigma: Annotated[Mapping[str, float], RequiredSigma] = Field(
        default_factory=RequiredSigma
    )
    """required 1-sigma of each axis of a block of the error state, by block name with unit"""
    wheels: Wheels | None = None
    """reaction wheels that rotate the satellite"""
    magnetorquers: Magnetorquers | None = None
    """magnetorquers; without wheels, they rotate the satellite"""
    path_constraints: tuple[PathConstraint, ...] = ()
    """cones that must contain or exclude a direction during the whole plan"""
    windows: tuple[Window, ...] = ()
    """time windows, one of which must contain a plan from start to end; default: any time"""
    monte_carlo: MonteCarloSettings | None = None
    """Monte Carlo runs in which plans are evaluated; default: the nominal run alone"""
    prior: Prior | None = None
    """result of a calibration, which replaces initial attitude, rate and 1-sigmas"""

    def __post_init__(self) -> None:
        units = self.suite.units
        check_consistency(self, self.suite)
        try:
            orbit = self.orbit.prepare_for_run(self.epoch, self.latest_end)
            object.__setattr__(self, "orbit", orbit)
        except InvalidValue as error:
            raise error.prefix_key("orbit") from None
        check_blocks("trace_weights", self.trace_weights, units)
        keys = [unit.build_key(block) for block, unit in units.items()]
        check_blocks("required_sigma", self.required_sigma, keys)
        check_objectives(self.objectives, units, bool(self.required_sigma))

    @property
    def suite(self) -> Suite:
        """Gyro, sensors and environment model errors with their combined error state.

        The sample noise of the gyro is included in its angle random walk, for one sample per step.
        """
        return Suite(
            self.gyro.convert_sample_noise(self.step), self.sensors, self.environment_errors
        )

    @property
    def n_steps(self) -> int:
        """Number of filter steps in the duration of the scenario."""
        return round(self.duration / self.step)

    @property
    def deadline(self) -> float:
        """Latest time at which a plan may end, including the slew back [s after the epoch].

        The deadline is infinite without time windows. It is earlier by the largest start delay of
        Monte Carlo runs.
        """
        return compute_deadline(self)

    @property
    def latest_end(self) -> float:
        """Latest end of a run [s after the epoch]: the duration plus the largest start delay."""
        return self.duration + (0.0 if self.monte_carlo is None else self.monte_carlo.start_delay)

    def shift_start(self, time: float) -> Scenario:
        """Return a copy of the scenario that starts `time` seconds later, on the same orbit."""
        epoch = instant_after(self.epoch, time)
        return dataclasses.replace(self, epoch=epoch, orbit=self.orbit.shift_epoch(time))

    @property
    def is_magnetorquer_driven(self) -> bool:
        """True if magnetorquers alone rotate the satellite."""
        return self.magnetorquers is not None and self.wheels is None

    def build_rotation_dynamics(
        self, field: Floats, attitude: Floats, rate: Floats
    ) -> RotationDynamics:
        """Return a model of how the body rate changes: slew limits or magnetorquer control.

        The result is None if the rate changes instantaneously.

        Parameters
        ----------
        field : array, shape (n, 3)
            Geomagnetic field [T], GCRS, used by magnetorquers.
        attitude : array, shape (3, 3)
            Initial attitude, GCRS to body.
        rate : array, shape (3,)
            Initial body rate [rad/s].

        Returns
        -------
        SlewLimits, MagnetorquerDrive or None
        """
        if self.magnetorquers is not None and self.is_magnetorquer_driven:
            return self.magnetorquers.build_drive(field, attitude, rate)
        return build_slew_limits(self.maneuvers, self.wheels, rate)

    @property
    def needs_field(self) -> bool:
        """True if a sensor or an actuator of the scenario requires the geomagnetic field model."""
        has_dipole = self.wheels is not None and any(self.wheels.residual_dipole)
        has_dipole |= self.magnetorquers is not None and self.magnetorquers.unloads_wheels
        return (
            has_dipole
            or self.is_magnetorquer_driven
            or any(each.needs_field for each in self.sensors)
        )

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Assumptions about actuators that affect the results, one sentence each."""
        return list_assumptions(self.wheels, self.magnetorquers)

    @property
    def times(self) -> Floats:
        """Sample times k * step [s after the epoch], shape (n_steps + 1,)."""
        return self.step * np.arange(self.n_steps + 1, dtype=np.float64)

    def compute_initial_attitude(self, orbit_state: Environment | SatelliteState) -> Floats:
        """Return the attitude matrix at the epoch, GCRS to body, shape (3, 3).

        Parameters
        ----------
        orbit_state : Environment or SatelliteState
            State of the satellite at the epoch.
        """
        return (
            self.initial.compute_attitude(orbit_state)[0]
            if self.prior is None
            else self.prior.attitude
        )

    def compute_initial_rate(self, orbit_state: Environment | SatelliteState) -> Floats:
        """Return the body rate at the epoch [rad/s], shape (3,).

        Parameters
        ----------
        orbit_state : Environment or SatelliteState
            State of the satellite at the epoch.
        """
        return self.initial.compute_rate(orbit_state) if self.prior is None else self.prior.rate

    @property
    def initial_attitude_covariance(self) -> Floats:
        """Covariance of the attitude error at the epoch [rad²], shape (3, 3)."""
        if self.prior is None:
            return float(np.radians(self.initial.attitude_deg)) ** 2 * np.eye(3)
        return np.array(self.prior.covariance)[:3, :3]

    @staticmethod
    def paper() -> Scenario:
        """Return the scenario of the paper by Hott, Chagas and de Sousa (Table 2).

        Values that the paper does not state are chosen to reproduce its fronts; comments in the
        file ``scenario/paper.toml`` mark them.
        """
        return Scenario.from_dict({"preset": "paper"})

    @staticmethod
    def cubesat_1u() -> Scenario:
        """Return the preset of a 1U CubeSat with magnetorquers as the only actuators.

        Comments in the file ``scenario/cubesat_1u.toml`` list the sources of its values.
        """
        return Scenario.from_dict({"preset": "cubesat_1u"})

    @staticmethod
    def microsatellite() -> Scenario:
        """Return the preset of a 110 kg satellite with two star trackers and reaction wheels.

        Comments in the file ``scenario/microsatellite.toml`` list the sources of its values.
        """
        return Scenario.from_dict({"preset": "microsatellite"})

    @staticmethod
    def cubesat_6u() -> Scenario:
        """Return the preset of a 6U CubeSat with small instruments.

        The orbit is that of the paper, but with eclipses. With the rule "trace", the filter
        converges when the trace falls by less than 1 % over 300 s, which is later than for the
        paper's satellite.
        """
        return Scenario.from_dict({"preset": "cubesat_6u"})

    @staticmethod
    def cubesat_6u_full() -> Scenario:
        """Return the preset `cubesat_6u` with all modeled errors of instruments and environment.

        The errors are constant or time-varying. Comments in the file
        ``scenario/cubesat_6u_full.toml`` list the sources of its values.
        """
        return Scenario.from_dict({"preset": "cubesat_6u_full"})

    def to_dict(self) -> dict[str, Any]:
        """Return the scenario as nested dicts and lists of JSON types, which `from_dict` reads."""
        table = to_table(self)
        if self.objectives == PAPER_OBJECTIVES:  # A default is not written.
            del table["objectives"]
        return table

    @staticmethod
    def from_dict(table: Mapping[str, Any], folder: str | os.PathLike[str] = "") -> Scenario:
        """Build a scenario from nested dicts and lists.

        A preset or a calibration may provide the missing keys.

        With ``preset``, the table overrides the preset key by key. With ``after``, a calibration as
        saved in JSON, the table overrides the scenario that continues from its time, attitude and
        covariance; see `Calibration.build_followup_scenario`.

        A list of sensors replaces that of the preset. A sensor inherits missing keys from the
        preset's sensor of its name and kind, or from the only one of its kind, or uses defaults.

        Parameters
        ----------
        table : mapping
            Tables and keys of a scenario file; see `to_dict`.
        folder : path, optional
            Folder to which the path ``orbit.file`` is relative.

        Raises
        ------
        InvalidValue
            If a key is unknown, missing or invalid; the message has the full key, such as
            ``orbit.eccentricity``.
        """
        if not isinstance(table.get("gyro", {}), Mapping):
            raise InvalidValue("gyro", table["gyro"], _NO_GYRO)
        if "after" in table:
            table = continue_scenario(table, Scenario.from_dict)
        return Scenario(**_resolve_orbit_file(merge_preset(table), folder))

    def to_toml(self) -> str:
        """Return the scenario as the text of a TOML file, with a comment on every key."""
        units = self.suite.units
        keys = {
            "trace_weights": units,
            "required_sigma": [unit.build_key(block) for block, unit in units.items()],
        }
        notes = {key: f"Valid names: {', '.join(blocks)}" for key, blocks in keys.items()}
        return to_toml(self, self.to_dict(), notes)

    @staticmethod
    def from_toml(source: str | os.PathLike[str]) -> Scenario:
        """Read a scenario from a TOML file, or from a string that contains TOML.

        The key ``preset`` works as in `from_dict`. The path ``orbit.file`` is relative to the
        folder of the file.

        Parameters
        ----------
        source : path or str
            A path object or a one-line string that ends in ``.toml`` is a file; any other string is
            TOML text.

        Raises
        ------
        ScenarioFileError
            (ValueError) If the file is invalid; the message names the file and the key, or the line
            of a syntax error.

        Warns
        -----
        ImplausibleValue
            If a value is likely an error; see `find_implausible_values`.
        """
        origin, folder, table = read_toml(source)
        try:
            scenario = Scenario.from_dict(table, folder)
        except ValueError as error:
            raise ScenarioFileError(f"{origin}: {error}") from error
        for line in find_implausible_values(scenario):
            warnings.warn(f"{origin}: {line}", ImplausibleValue, stacklevel=2)
        return scenario

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the scenario to a TOML file.

        An existing file is replaced atomically.
        """
        write_file(Path(path), self.to_toml().encode())


def _resolve_orbit_file(table: dict[str, Any], folder: str | os.PathLike[str]) -> dict[str, Any]:
    orbit = table.get("orbit")
    if not isinstance(orbit, Mapping) or not isinstance(orbit.get("file"), str):
        return table
    return table | {"orbit": {**orbit, "file": os.path.join(folder, orbit["file"])}}
