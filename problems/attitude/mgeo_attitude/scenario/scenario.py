"""The scenario: everything a run of the filter depends on, checked as a whole."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ..constants import FIELD_MODEL_END, FIELD_MODEL_START
from ..environment.orbit import ORBITS, AnyOrbit
from ..fields import InvalidValue, Kinds, positive, quantity, to_table
from ..files import write_text
from ..sensors import SENSORS, Gyro, Sensor
from .limits import Limits
from .objective_names import NAMES, PAPER, TRACE_OF, check_objectives
from .presets import PRESETS, on_preset
from .settings import (
    Convergence,
    InitialUncertainty,
    ManeuverLimits,
    TraceWeights,
    check_blocks,
    state_units,
)
from .toml import ScenarioFileError, read_toml, to_toml

_MAX_COUNT = 2**31  # with more steps than this any remainder would be within rounding
# What is kept of each step would fill the memory: of the run, once; of the window, for each design.
_MAX_STEPS = {"duration": 1_000_000, "convergence.window": 100_000}
_MULTIPLE_TOLERANCE = 1e-9  # relative; decimal steps such as 0.1 s are not exact in binary


@dataclass(frozen=True, kw_only=True)
class Scenario(Limits):
    """Orbit, instruments, limits and criteria of one study; frozen, hashable and picklable.

    An epoch with another UTC offset is converted to UTC; a naive one is refused.

    Raises
    ------
    InvalidType, InvalidValue
        (TypeError, ValueError) Naming the key, its value and what was expected.
    """

    name: str = quantity("custom", doc="name of the scenario, on one line")
    epoch: datetime = quantity(doc="start of the run with its UTC offset; Z is UTC")
    duration: float = positive(unit="s", doc="longest simulated time, a multiple of the step")
    step: float = positive(1.0, unit="s", doc="time step of the filter")
    eclipse: bool = quantity(False, doc="whether the Earth's shadow blinds the Sun sensors")
    objectives: tuple[str, ...] = quantity(
        PAPER, doc=f"what to minimize, of {', '.join(NAMES)}, {TRACE_OF}BLOCK,BLOCK..."
    )
    orbit: AnyOrbit = quantity(
        kinds=ORBITS, doc="elements at the epoch, or propagator = 'sgp4' with line1 and line2"
    )
    gyro: Gyro = quantity(factory=Gyro, doc="three-axis gyro")
    sensors: tuple[Sensor, ...] = quantity(
        kinds=Kinds("kind", SENSORS), doc="sensors, at least one, each with its own name"
    )
    initial: InitialUncertainty = quantity(
        factory=InitialUncertainty, doc="what is known at the start"
    )
    maneuvers: ManeuverLimits = quantity(factory=ManeuverLimits, doc="bounds of the design vector")
    convergence: Convergence = quantity(
        factory=Convergence, doc="when the filter counts as converged"
    )
    trace_weights: Annotated[Mapping[str, float], TraceWeights] = quantity(
        factory=TraceWeights,
        low=0.0,
        doc="weight of each state block in the trace, 1 where none is given",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.name.isprintable() or not self.name.strip():
            raise InvalidValue("name", self.name, "expected printable characters on one line")
        self._check_steps()
        self._check_epoch()
        self._check_sensors()
        units = state_units(self.gyro, self.sensors)
        check_blocks("trace_weights", self.trace_weights, units)
        if not any(TraceWeights(self.trace_weights).of(units)):
            expected = "expected a weight above 0"
            raise InvalidValue("trace_weights", dict(self.trace_weights), expected)
        self.check_limits(units, self.initial.attitude_deg)
        check_objectives(self.objectives, units, bool(self.required_sigma))

    @property
    def n_steps(self) -> int:
        """Number of steps of the whole duration."""
        return round(self.duration / self.step)

    @property
    def times(self) -> NDArray[np.float64]:
        """Sample times k * step since the epoch [s], shape (n_steps + 1,)."""
        return self.step * np.arange(self.n_steps + 1, dtype=np.float64)

    @staticmethod
    def paper() -> Scenario:
        """Table 2 of Hott, Chagas & de Sousa; what it leaves open reproduces its fronts.

        Its file, ``scenario/paper.toml``, says which values are ours.
        """
        return Scenario.from_dict({"preset": "paper"})

    @staticmethod
    def cubesat_6u() -> Scenario:
        """A 6U cubesat with small instruments, in the paper's orbit with its eclipses.

        It counts as converged later than the paper's satellite: below 1 % over 300 s.
        """
        return Scenario.from_dict({"preset": "cubesat_6u"})

    def to_dict(self) -> dict[str, Any]:
        """The scenario as nested dicts and lists of JSON's types; see `from_dict`."""
        table = to_table(self)
        if self.objectives == PAPER:  # they go without saying
            del table["objectives"]
        return table

    @staticmethod
    def from_dict(table: Mapping[str, Any]) -> Scenario:
        """Inverse of `to_dict`; ``preset`` names a preset that `table` overrides key by key.

        A list of sensors replaces the preset's. What one of them leaves out is that of the preset's
        sensor of the same name and kind, or else of its only one of the kind, or else the kind's
        default.

        Raises
        ------
        InvalidValue, InvalidType
            Naming the full key (``orbit.eccentricity``): unknown, missing or of a bad value.
        """
        from ..fields.checking import from_table

        return from_table(Scenario, on_preset(table), "preset", PRESETS)

    def to_toml(self) -> str:
        """The scenario as a TOML document with a comment on every key."""
        units = state_units(self.gyro, self.sensors)
        keys = {
            "trace_weights": units,
            "required_sigma": [unit.key(block) for block, unit in units.items()],
        }
        notes = {key: f"The blocks: {', '.join(blocks)}" for key, blocks in keys.items()}
        return to_toml(self, self.to_dict() | {"epoch": self.epoch}, notes)

    @staticmethod
    def from_toml(source: str | os.PathLike[str]) -> Scenario:
        """Read a TOML file, or TOML text; ``preset = "..."`` works as in `from_dict`.

        Parameters
        ----------
        source : path or str
            A path object, or a one-line string ending in ``.toml``, is a file; any other string
            is the text itself.

        Raises
        ------
        ScenarioFileError
            (ValueError) Naming the file and the key, or the line where it is no TOML.
        """
        origin, table = read_toml(source)
        try:
            return Scenario.from_dict(table)
        except ValueError as error:
            raise ScenarioFileError(f"{origin}: {error}") from error

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write `to_toml` to a file, which is replaced as a whole or not at all."""
        write_text(Path(path), self.to_toml())

    def _check_steps(self) -> None:
        for key, span in (
            ("duration", self.duration),
            ("convergence.window", self.convergence.window),
        ):
            if not _is_multiple(span, self.step):
                raise InvalidValue(key, span, f"expected a multiple of step = {self.step!r} s")
            if round(span / self.step) > _MAX_STEPS[key]:
                raise InvalidValue(
                    key, span, f"expected at most {_MAX_STEPS[key]} times step = {self.step!r} s"
                )
        if self.convergence.window > self.duration:
            raise InvalidValue(
                "convergence.window",
                self.convergence.window,
                f"expected at most duration = {self.duration!r} s",
            )

    def _check_epoch(self) -> None:
        if self.epoch.utcoffset() is None:
            raise InvalidValue(
                "epoch", self.epoch.isoformat(), "expected a UTC offset, such as a Z at the end"
            )
        start, end = FIELD_MODEL_START, FIELD_MODEL_END
        if not start <= self.epoch <= end or self.duration > (end - self.epoch).total_seconds():
            raise InvalidValue(
                "epoch",
                self.epoch.isoformat(),
                f"expected a run of duration = {self.duration!r} s inside the field model IGRF-14, "
                f"from {start:%Y-%m-%d} to {end:%Y-%m-%d} UTC",
            )
        object.__setattr__(self, "epoch", self.epoch.astimezone(UTC))
        try:
            self.orbit.check_epoch(self.epoch)
        except InvalidValue as error:
            raise error.under("orbit") from None

    def _check_sensors(self) -> None:
        if not self.sensors:
            raise InvalidValue("sensors", [], "expected at least one sensor")
        names: list[str] = []
        for i, sensor in enumerate(self.sensors):
            key = f"sensors[{i}].name"
            if not re.fullmatch(r"[\w-]+", sensor.name, re.ASCII):
                raise InvalidValue(key, sensor.name, "expected letters, digits, '-' and '_'")
            if sensor.name in ("gyro", *names):
                raise InvalidValue(
                    key, sensor.name, "expected a name that no other sensor nor the gyro has"
                )
            names.append(sensor.name)


def _is_multiple(span: float, step: float) -> bool:
    ratio = span / step
    if not 0.5 < ratio < _MAX_COUNT:
        return False
    return math.isclose(round(ratio) * step, span, rel_tol=_MULTIPLE_TOLERANCE)
