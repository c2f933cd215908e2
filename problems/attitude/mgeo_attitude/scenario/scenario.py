"""The scenario: everything a run of the filter depends on, checked as a whole."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..constants import FIELD_MODEL_END, FIELD_MODEL_START
from ..fields import InvalidValue, Validated, quantity
from ..sensors import Gyro, Sensor
from .limits import KeepOut, Wheels
from .objective_names import NAMES, PAPER, TRACE_OF, check_objectives
from .orbit import Orbit, TLEOrbit
from .settings import (
    BlockValues,
    Convergence,
    InitialUncertainty,
    ManeuverLimits,
    RequiredSigma,
    TraceWeights,
    state_blocks,
    state_units,
)
from .suggestions import known_names

Values = TypeVar("Values", bound=BlockValues)

#: An element set older than this places the satellite tens of kilometers off and more.
MAX_TLE_AGE = timedelta(days=30)

_MAX_COUNT = 2**31  # with more steps than this any remainder would be within rounding
# What is kept of each step would fill the memory: of the run, once; of the window, for each design.
_MAX_STEPS = {"duration": 1_000_000, "convergence.window": 100_000}
_MULTIPLE_TOLERANCE = 1e-9  # relative; decimal steps such as 0.1 s are not exact in binary


@dataclass(frozen=True, kw_only=True)
class Scenario(Validated):
    """Orbit, instruments, limits and criteria of one study; frozen, hashable and picklable.

    An epoch with another UTC offset is converted to UTC; a naive one is refused.

    Raises
    ------
    InvalidType, InvalidValue
        (TypeError, ValueError) Naming the key, its value and what was expected.
    """

    name: str = quantity("custom", doc="name of the scenario, on one line")
    epoch: datetime = quantity(doc="start of the run with its UTC offset; Z is UTC")
    duration: float = quantity(
        unit="s", low=0.0, open_low=True, doc="longest simulated time, a multiple of the step"
    )
    step: float = quantity(1.0, unit="s", low=0.0, open_low=True, doc="time step of the filter")
    eclipse: bool = quantity(False, doc="whether the Earth's shadow blinds the Sun sensors")
    objectives: tuple[str, ...] = quantity(
        PAPER, doc=f"what to minimize, of {', '.join(NAMES)}, {TRACE_OF}BLOCK,BLOCK..."
    )
    orbit: Orbit | TLEOrbit = quantity(
        doc="elements at the epoch, or propagator = 'sgp4' with line1 and line2"
    )
    gyro: Gyro = quantity(Gyro(), doc="three-axis gyro")
    sensors: tuple[Sensor, ...] = quantity(doc="sensors, at least one, each with its own name")
    initial: InitialUncertainty = quantity(InitialUncertainty(), doc="what is known at the start")
    maneuvers: ManeuverLimits = quantity(ManeuverLimits(), doc="bounds of the design vector")
    convergence: Convergence = quantity(Convergence(), doc="when the filter counts as converged")
    trace_weights: Mapping[str, float] = quantity(
        TraceWeights(), doc="weight of each state block in the trace, 1 where none is given"
    )
    required_sigma: Mapping[str, float] = quantity(
        RequiredSigma(), doc="1-sigma that each axis of a state block must reach, by key with unit"
    )
    wheels: Wheels | None = quantity(None, doc="reaction wheels that turn the satellite")
    keep_outs: tuple[KeepOut, ...] = quantity((), doc="cones that the Sun must stay out of")

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.name.isprintable() or not self.name.strip():
            raise InvalidValue("name", self.name, "expected printable characters on one line")
        self._check_steps()
        self._check_epoch()
        self._check_sensors()
        self._check_weights()
        blocks = state_blocks(self.gyro, self.sensors)
        check_objectives(self.objectives, blocks, bool(self.required_sigma))
        self._check_keep_outs()

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
        """The scenario of the paper (Table 2), with what it leaves open filled in."""
        from .presets import paper  # the presets are scenarios themselves

        return paper()

    @staticmethod
    def cubesat_6u() -> Scenario:
        """A 6U cubesat with small instruments, in the paper's orbit with its eclipses."""
        from .presets import cubesat_6u

        return cubesat_6u()

    def to_dict(self) -> dict[str, Any]:
        """The scenario as nested dicts and lists of JSON's types; see `from_dict`."""
        from .tables import to_table

        return to_table(self)

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
        from .tables import from_table

        return from_table(table)

    def to_toml(self) -> str:
        """The scenario as a TOML document with a comment on every key."""
        from .toml import to_toml

        return to_toml(self)

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
        from .toml import from_toml

        return from_toml(source)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write `to_toml` to a file, which is replaced as a whole or not at all."""
        from .toml import save

        save(self, path)

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
        if isinstance(self.orbit, TLEOrbit) and abs(self.epoch - self.orbit.epoch) > MAX_TLE_AGE:
            raise InvalidValue(
                "orbit.line1",
                self.orbit.line1,
                f"expected an element set within {MAX_TLE_AGE.days} days of epoch = "
                f"{self.epoch.isoformat()}, not of {self.orbit.epoch.isoformat()}",
            )

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

    def _check_weights(self) -> None:
        units = state_units(self.gyro, self.sensors)
        weights = self._checked_blocks("trace_weights", TraceWeights, list(units))
        if not any(weights.of(units)):
            raise InvalidValue("trace_weights", dict(weights), "expected a weight above 0")
        keys = [unit.key(block) for block, unit in units.items()]
        self._checked_blocks("required_sigma", RequiredSigma, keys)

    def _check_keep_outs(self) -> None:
        for i, cone in enumerate(self.keep_outs):
            most = (180.0 - cone.half_angle_deg) / self.initial.attitude_deg
            if cone.attitude_sigmas >= most:
                raise InvalidValue(
                    f"keep_outs[{i}].attitude_sigmas",
                    cone.attitude_sigmas,
                    f"expected less than {most:.4g}: with initial.attitude_deg = "
                    f"{self.initial.attitude_deg!r} no attitude is that far from half_angle_deg = "
                    f"{cone.half_angle_deg!r}",
                )

    def _checked_blocks(self, key: str, kind: type[Values], known: list[str]) -> Values:
        """Turn a mapping into block values of this suite, or raise an error."""
        try:
            values = kind(getattr(self, key))
        except InvalidValue as error:
            raise error.under(key) from None
        for block, value in values.items():
            if block not in known:
                raise InvalidValue(
                    f"{key}.{block}", value, f"unknown state block{known_names(block, known)}"
                )
        object.__setattr__(self, key, values)
        return values


def _is_multiple(span: float, step: float) -> bool:
    ratio = span / step
    if not 0.5 < ratio < _MAX_COUNT:
        return False
    return math.isclose(round(ratio) * step, span, rel_tol=_MULTIPLE_TOLERANCE)
