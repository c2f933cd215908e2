"""The scenario: everything a run of the filter depends on, checked as a whole."""

from __future__ import annotations

import dataclasses
import math
import os
import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from mgeo.store.atomic import write_file
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.constants import FIELD_MODEL_END, FIELD_MODEL_START
from mgeo_attitude.environment.orbit import ORBITS, AnyOrbit
from mgeo_attitude.environment.time_frames import elapsed
from mgeo_attitude.fields import (
    InvalidType,
    InvalidValue,
    Kinds,
    Validated,
    expect,
    from_table,
    positive,
    quantity,
    to_table,
)
from mgeo_attitude.scenario.after import going_on
from mgeo_attitude.scenario.channels import Channel, check_channels
from mgeo_attitude.scenario.coils import Coils, assumed, check_coils
from mgeo_attitude.scenario.flight import FlightErrors
from mgeo_attitude.scenario.initial import InitialConditions, Sight
from mgeo_attitude.scenario.older import updated
from mgeo_attitude.scenario.path_limits import PathLimit
from mgeo_attitude.scenario.presets import PRESETS, on_preset
from mgeo_attitude.scenario.prior import Prior
from mgeo_attitude.scenario.settings import (
    NAMES,
    PAPER,
    TRACE_OF,
    Convergence,
    ManeuverLimits,
    RequiredSigma,
    TraceWeights,
    check_blocks,
    check_name,
    check_objectives,
)
from mgeo_attitude.scenario.toml import ScenarioFileError, read_toml, to_toml
from mgeo_attitude.scenario.wheels import Wheels
from mgeo_attitude.scenario.windows import Contact, Window, deadlines, start_times
from mgeo_attitude.sensors import SENSORS, Gyro, Sensor, World
from mgeo_attitude.sensors.suite import Suite

_MAX_COUNT = 2**31  # with more steps than this any remainder would be within rounding
# What is kept of each step would fill the memory: of the run, once; of the window, for each design.
_MAX_STEPS = {"duration": 1_000_000, "convergence.window": 100_000}
_TOLERANCE = 1e-9  # relative; decimal steps such as 0.1 s are not exact in binary
_NO_GYRO = (
    "expected a table of its keys: the filter needs a gyro, see 'Without a gyro' in docs/errors.md"
)


@dataclass(frozen=True, kw_only=True)
class Scenario(Validated):
    """Orbit, instruments, limits and criteria of one study; frozen, hashable and picklable.

    An epoch with another UTC offset is converted to UTC; a naive one is refused.

    Raises
    ------
    InvalidType, InvalidValue
        (TypeError, ValueError) Naming the key, its value and what was expected.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> scenario = Scenario.from_dict({"preset": "cubesat_6u", "duration": 5400.0})
    >>> scenario.save("mine.toml")
    >>> Scenario.from_toml("mine.toml") == scenario
    True
    """

    name: str = quantity("custom", doc="name of the scenario, on one line")
    epoch: datetime = quantity(doc="start of the run with its UTC offset; Z is UTC")
    duration: float = positive(
        unit="s", doc="longest time to converge, a multiple of the step; a slew back may end later"
    )
    step: float = positive(1.0, unit="s", doc="time step of the filter")
    eclipse: bool = quantity(True, doc="whether the Earth's shadow blinds the Sun sensors")
    objectives: tuple[str, ...] = quantity(
        PAPER, doc=f"what to minimize, of {', '.join(NAMES)}, {TRACE_OF}BLOCK,BLOCK..."
    )
    orbit: AnyOrbit = quantity(
        kinds=ORBITS, doc="elements at the epoch, an element set, or an ephemeris"
    )
    gyro: Gyro = quantity(factory=Gyro, doc="three-axis gyro")
    sensors: tuple[Sensor, ...] = quantity(
        kinds=Kinds("kind", SENSORS), doc="sensors, at least one, each with its own name"
    )
    world: World = quantity(
        factory=World, doc="errors of field, orbit and light from the Earth, shared by all sensors"
    )
    channels: tuple[Channel, ...] = quantity(
        (), doc="what something else on board will measure, which biases follow"
    )
    initial: InitialConditions = quantity(
        factory=InitialConditions,
        doc="attitude and body rate at the start, and what is known of it",
    )
    maneuvers: ManeuverLimits = quantity(factory=ManeuverLimits, doc="bounds of the design vector")
    convergence: Convergence = quantity(
        factory=Convergence, doc="when the filter counts as converged"
    )
    trace_weights: Annotated[Mapping[str, float], TraceWeights] = quantity(
        factory=TraceWeights,
        low=0.0,
        doc="weight of each state block in the trace; where none is given 1, but 0 for errors that "
        "vary or are considered",
    )
    required_sigma: Annotated[Mapping[str, float], RequiredSigma] = positive(
        factory=RequiredSigma,
        doc="1-sigma that each axis of a state block must reach, by key with unit",
    )
    wheels: Wheels | None = quantity(None, doc="reaction wheels that turn the satellite")
    coils: Coils | None = quantity(None, doc="magnetic coils; without wheels they turn it")
    path_limits: tuple[PathLimit, ...] = quantity(
        (),
        doc="cones that a direction must stay out of, or in, along the way",
        formerly="keep_outs",
    )
    windows: tuple[Window, ...] = quantity(
        (), doc="times in which a plan may be flown from start to end; none is any time"
    )
    contacts: tuple[Contact, ...] = quantity(
        (), doc="ground contacts, in one of which a plan begins; none is any time"
    )
    flight: FlightErrors | None = quantity(
        None, doc="flights over which plans are judged; without it each is flown exactly"
    )
    prior: Prior | None = quantity(
        None, doc="what a calibration has found, in place of initial attitude, rate and 1-sigmas"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_name(self.name)
        units = self.suite.units
        self._check_together(self.suite)
        object.__setattr__(self, "epoch", self.epoch.astimezone(UTC))
        try:
            last = self.duration + (self.maneuvers.latest_start or 0.0)
            object.__setattr__(self, "orbit", self.orbit.for_run(self.epoch, last))
        except InvalidValue as error:
            raise error.under("orbit") from None
        check_blocks("trace_weights", self.trace_weights, units)
        keys = [unit.key(block) for block, unit in units.items()]
        check_blocks("required_sigma", self.required_sigma, keys)
        check_objectives(self.objectives, units, bool(self.required_sigma))

    @property
    def suite(self) -> Suite:
        """Gyro, sensors and world as one error state."""
        return Suite(self.gyro, self.sensors, self.world)

    @property
    def n_steps(self) -> int:
        """Number of steps of the whole duration."""
        return round(self.duration / self.step)

    @property
    def deadline(self) -> float:
        """When a plan has to be over, slew back included [s]; infinite without windows.

        It is over even if it begins as late as the flights that it is judged over. Where the start
        is free this is the latest of all starts, each from its own on.
        """
        return float(deadlines(self, self.start_times).max())

    @property
    def start_times(self) -> Floats:
        """When a plan may begin, [s] after the epoch, ascending: then, unless the start is free."""
        return start_times(self)

    def starting(self, time: float) -> Scenario:
        """The same whose plans begin at a time [s] after the epoch, which is then theirs."""
        epoch = self.epoch + timedelta(seconds=time)
        epoch -= timedelta(seconds=elapsed(self.epoch, epoch) - time)  # leap seconds
        return dataclasses.replace(
            self,
            epoch=epoch,
            orbit=self.orbit.later(time),
            maneuvers=dataclasses.replace(self.maneuvers, latest_start=None, start_interval=None),
        )

    @property
    def turned_by_coils(self) -> bool:
        """Whether it has coils and no wheels."""
        return self.coils is not None and self.wheels is None

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

    def initial_attitude(self, at: Sight) -> Floats:
        """GCRS to body at the epoch, of which `at` is; shape (3, 3)."""
        return self.initial.attitude(at)[0] if self.prior is None else self.prior.attitude

    def initial_rate(self, at: Sight) -> Floats:
        """Body rate at the epoch [rad/s], shape (3,)."""
        return self.initial.rate(at) if self.prior is None else self.prior.rate

    @property
    def initial_attitude_covariance(self) -> Floats:
        """Of the attitude error at the epoch [rad²], shape (3, 3)."""
        if self.prior is None:
            return float(np.radians(self.initial.attitude_deg)) ** 2 * np.eye(3)
        covariance: Floats = np.array(self.prior.covariance)[:3, :3]
        return covariance

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
        InvalidValue, InvalidType
            Naming the full key (``orbit.eccentricity``): unknown, missing or of a bad value.
        """
        table = updated(table)
        if not isinstance(table.get("gyro", {}), Mapping):
            raise InvalidType("gyro", table["gyro"], _NO_GYRO)
        if "after" in table:
            table = going_on(table, Scenario.from_dict)
        return from_table(Scenario, _in_folder(on_preset(table), folder), "preset")

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
        from mgeo_attitude.scenario.plausible import Implausible, implausible

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

    def _check_together(self, suite: Suite) -> None:
        """Refuse, with an InvalidValue, what does not go with other fields."""
        step, window = f"step = {self.step!r} s", self.convergence.window
        most = f"at most duration = {self.duration!r} s"
        for key, span in (("duration", self.duration), ("convergence.window", window)):
            expect(_is_multiple(span, self.step), key, span, f"a multiple of {step}")
            few = round(span / self.step) <= _MAX_STEPS[key]
            expect(few, key, span, f"at most {_MAX_STEPS[key]} times {step}")
        rate = self.maneuvers.max_rate_deg_s
        # between samples half a turn apart nobody could tell which way the body turned
        fastest = 180.0 / (math.sqrt(3.0) * self.step)
        slow = (
            f"less than {fastest:.4g}, so that turned at about all axes it is less than 180 deg in "
            f"{step}; or a step below {180.0 / (math.sqrt(3.0) * rate):.4g} s"
        )
        expect(rate < fastest, "maneuvers.max_rate_deg_s", rate, slow)
        gyro_range = self.gyro.range_deg_per_s
        within = f"at most gyro.range_deg_per_s = {gyro_range!r}"
        expect(gyro_range is None or rate <= gyro_range, "maneuvers.max_rate_deg_s", rate, within)
        for i, sensor in enumerate(self.sensors):
            interval, key = sensor.sample_interval, f"sensors[{i}].sample_interval"
            fits = interval is None or _is_multiple(interval, self.step)
            expect(fits, key, interval, f"a multiple of {step}")
            expect((interval or 0.0) <= self.duration, key, interval, most)
        expect(window <= self.duration, "convergence.window", window, most)
        possible = self.required_sigma or self.convergence.rule != "required"
        others = "another rule, or something in required_sigma"
        expect(possible, "convergence.rule", self.convergence.rule, others)

        check_channels(self.channels)
        check_coils(self.coils, self.wheels, self.maneuvers, self.step)
        epoch, start, end = self.epoch, FIELD_MODEL_START, FIELD_MODEL_END
        zone = epoch.utcoffset() is not None
        expect(zone, "epoch", epoch.isoformat(), "a UTC offset, such as a Z at the end")
        last = self.duration + (self.maneuvers.latest_start or 0.0)
        inside = start <= epoch <= end and last <= (end - epoch).total_seconds()
        years = (
            f"a run of duration = {self.duration!r} s inside the field model IGRF-14, from "
            f"{start:%Y-%m-%d} to {end:%Y-%m-%d} UTC, or nothing that needs the field, as "
            "magnetometers, coils that turn the satellite and a residual dipole do"
        )
        expect(inside or not self.needs_field, "epoch", epoch.isoformat(), years)

        self._check_starts()
        names = [sensor.name for sensor in self.sensors]
        expect(names, "sensors", [], "at least one sensor")
        for i, name in enumerate(names):
            key, sound = f"sensors[{i}].name", re.fullmatch(r"[\w-]+", name, re.ASCII)
            expect(sound, key, name, "letters, digits, '-' and '_'")
            new = name not in ("gyro", "world", *names[:i])
            expect(new, key, name, "a name that no other sensor has, nor gyro or world")

        weights = TraceWeights(self.trace_weights)
        some = any(weights.of(suite.blocks, suite.uncalibrated))
        expect(some, "trace_weights", dict(weights), "a weight above 0")
        if self.prior is not None:
            blocks, found = suite.blocks[1:], len(self.prior.states)
            same = f"{len(blocks)} rows, of {', '.join(blocks)}"
            expect(found == len(blocks), "prior.states", f"{found} rows", same)
        for i, limit in enumerate(self.path_limits if self.prior is None else ()):
            room = limit.half_angle_deg if limit.keep_in else 180.0 - limit.half_angle_deg
            fewest = room / self.initial.attitude_deg
            far = (
                f"less than {fewest:.4g}: with initial.attitude_deg = "
                f"{self.initial.attitude_deg!r} no attitude is that far "
                f"{'inside' if limit.keep_in else 'from'} half_angle_deg = {limit.half_angle_deg!r}"
            )
            # of a disc the angle counts from its limb: what is left depends on where that is
            fits = limit.attitude_sigmas < fewest or limit.cone().disc
            expect(fits, f"path_limits[{i}].attitude_sigmas", limit.attitude_sigmas, far)

    def _check_starts(self) -> None:
        """Refuse, with an InvalidValue, starts that do not go with other fields, or none."""
        limits, key = self.maneuvers, "maneuvers.start_interval"
        if limits.latest_start is not None:
            samples = [sensor.sample_interval or self.step for sensor in self.sensors]
            for span in (self.step, *samples):
                fits = _is_multiple(limits.between_starts, span)
                of_all = f"a multiple of {span!r} s, a step or sample interval"
                expect(fits, key, limits.between_starts, of_all)
            few = (limits.latest_start + self.duration) / self.step <= _MAX_STEPS["duration"]
            most = f"with duration at most {_MAX_STEPS['duration']} times step = {self.step!r} s"
            expect(few, "maneuvers.latest_start", limits.latest_start, most)
            later = "no free start after a calibration, which knows attitude and errors of one time"
            expect(self.prior is None, "maneuvers.latest_start", limits.latest_start, later)
            fixed = "none beside [[channels]], which are of one start"
            expect(not self.channels, "maneuvers.latest_start", limits.latest_start, fixed)
        start_times(self)


def scenario_schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of what `Scenario.from_dict` takes, for editors.

    A file may leave out what its preset has, so only a file without one is told what is missing.
    What several keys say together, such as multiples of the step, is checked on reading only.

    Examples
    --------
    >>> from mgeo_attitude import scenario_schema
    >>> scenario_schema()["properties"]["step"]["description"]
    'time step of the filter [s]'
    """
    from mgeo_attitude.fields.checking import section_model

    dialect = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    schema = section_model(Scenario, "preset", PRESETS).model_json_schema()
    for section in schema["$defs"].values():
        section.pop("required", None)
    alone = {"required": schema.pop("required")}
    return dialect | schema | {"anyOf": [{"required": ["preset"]}, alone]}


def _in_folder(table: dict[str, Any], folder: str | os.PathLike[str]) -> dict[str, Any]:
    """The table with the full name of the orbit's file, if it names one."""
    orbit = table.get("orbit")
    if not isinstance(orbit, Mapping) or not isinstance(orbit.get("file"), str):
        return table
    return table | {"orbit": {**orbit, "file": os.path.join(folder, orbit["file"])}}


def _is_multiple(span: float, step: float) -> bool:
    count = span / step
    return 0.5 < count < _MAX_COUNT and math.isclose(round(count) * step, span, rel_tol=_TOLERANCE)
