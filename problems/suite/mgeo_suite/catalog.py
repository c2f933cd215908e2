"""Catalog of the available grades of gyros and attitude sensors, with their cost."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any

import pydantic.dataclasses
from mgeo_attitude import Gyro, Magnetometer, StarTracker, SunSensor
from mgeo_attitude.settings.base import Settings, get_fields, to_table
from mgeo_attitude.settings.errors import InvalidKey, InvalidValue, expect, format_known_names
from mgeo_attitude.settings.types import Unit
from pydantic import Field

from mgeo.validation.entries import convert_file_errors

#: Outward unit normal of each face of the satellite, in body axes.
FACES: dict[str, tuple[float, float, float]] = {
    "+x": (1.0, 0.0, 0.0),
    "-x": (-1.0, 0.0, 0.0),
    "+y": (0.0, 1.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "+z": (0.0, 0.0, 1.0),
    "-z": (0.0, 0.0, -1.0),
}
NONE = "none"  # name of the option without a sensor
_REQUIRED_SECTIONS = ("gyros", "magnetometers")
_MOUNTING_KEYS = ("kind", "name", "boresight")  # keys that the mounting place determines


@pydantic.dataclasses.dataclass(frozen=True)
class FaceSunSensor(SunSensor):
    """Sun sensor on a face of the satellite.

    A nonzero `initial_bias` adds bias states. Within the field of view of one Sun sensor, bias and
    misalignment are hardly distinguishable, so that the states of one of them suffice.
    """

    initial_bias: float = Field(default=0.0, ge=0.0)
    """initial 1-sigma of the bias of the unit vector, per axis; 0 omits the bias states"""


#: Class of the instruments in each section of a catalog file.
SECTIONS: Mapping[str, type[Any]] = {
    "gyros": Gyro,
    "magnetometers": Magnetometer,
    "sun_sensors": FaceSunSensor,
    "star_trackers": StarTracker,
}


@pydantic.dataclasses.dataclass(frozen=True, kw_only=True)
class GradeCost(Settings):
    """Price, mass and power of one grade of an instrument, with the source of the values."""

    name: str
    """name of the grade, unique in its section"""
    price_keur: Annotated[float, Unit("kEUR")] = Field(ge=0.0)
    """price, of the right order of magnitude"""
    mass_g: Annotated[float, Unit("g")] = Field(ge=0.0)
    """mass"""
    power_mw: Annotated[float, Unit("mW")] = Field(ge=0.0)
    """average power"""
    source: str
    """source of the values"""


@dataclass(frozen=True)
class Grade:
    """Quality grade of a gyro or sensor: its cost and its error model.

    Attributes
    ----------
    cost : GradeCost
        Name, price, mass and power.
    instrument : Gyro or Sensor
        Gyro or sensor with the error parameters of the grade. Its mounting is not yet specified.
    """

    cost: GradeCost
    instrument: Any

    @property
    def name(self) -> str:
        return self.cost.name


@dataclass(frozen=True)
class Catalog:
    """Catalog of gyro and sensor grades, from which a sensor suite is selected.

    Catalogs are hashable. Grades have the order of the catalog file.

    Attributes
    ----------
    gyros, magnetometers, sun_sensors, star_trackers : tuples of Grade
        A suite has one gyro, one magnetometer, at most one Sun sensor per face, and at most one
        star tracker.
    faces : tuple of str
        Faces of `FACES` that may have a Sun sensor.

    Examples
    --------
    >>> from mgeo_suite import Catalog
    >>> [grade.name for grade in Catalog.default().gyros]
    ['mems', 'mems-tactical', 'fog']
    """

    gyros: tuple[Grade, ...]
    magnetometers: tuple[Grade, ...]
    sun_sensors: tuple[Grade, ...] = ()
    star_trackers: tuple[Grade, ...] = ()
    faces: tuple[str, ...] = tuple(FACES)

    @staticmethod
    @cache
    def default() -> Catalog:
        """Return the built-in catalog of CubeSat sensors.

        The file ``catalog.toml`` cites the sources of its values.
        """
        return Catalog.from_toml(Path(__file__).with_name("catalog.toml"))

    @staticmethod
    def from_toml(path: str | os.PathLike[str]) -> Catalog:
        """Read a catalog from a TOML file.

        Parameters
        ----------
        path : path
            TOML file with one array of tables per kind of instrument, such as ``[[gyros]]``.

        Raises
        ------
        ValueError
            If the file is invalid. The message names the file and the key, or the line of a syntax
            error.
        OSError
            If the file cannot be read.
        """
        with convert_file_errors(path):
            return Catalog.from_dict(tomllib.loads(Path(path).read_text(encoding="utf-8")))

    @staticmethod
    def from_dict(table: Mapping[str, Any]) -> Catalog:
        """Construct a catalog from nested dicts and lists, in the format of a catalog file.

        Parameters
        ----------
        table : mapping
            List of tables of each section, and optionally ``faces``.

        Raises
        ------
        InvalidValue
            (ValueError) If a key is unknown, missing or invalid, if a name is repeated, if a
            section lacks a required grade, or if the grades of a section differ in states, sample
            intervals or fields of view. The message names the full key, such as
            ``gyros[1].mass_g``.
        """
        known = [*SECTIONS, "faces"]
        for key, value in table.items():
            if key not in known:
                raise InvalidKey(str(key), value, f"unknown key{format_known_names(key, known)}")
        grades = {section: _build_grades(section, table.get(section, [])) for section in SECTIONS}
        for section in _REQUIRED_SECTIONS:
            expect(grades[section], section, [], f"at least one entry [[{section}]]")
        faces = _validate_faces(table.get("faces", list(FACES)))
        for section, entries in grades.items():
            _validate_traits(section, entries)
        return Catalog(**grades, faces=faces)

    def to_dict(self) -> dict[str, Any]:
        """Return the catalog as nested dicts and lists of JSON types, which `from_dict` accepts."""
        table: dict[str, Any] = {"faces": list(self.faces)}
        for section in SECTIONS:
            table[section] = [
                to_table(grade.cost)
                | {k: v for k, v in to_table(grade.instrument).items() if k not in _MOUNTING_KEYS}
                for grade in getattr(self, section)
            ]
        return table


def _build_grades(section: str, tables: Any) -> tuple[Grade, ...]:
    if not isinstance(tables, list | tuple):
        raise InvalidValue(section, tables, f"expected entries [[{section}]]")
    grades: list[Grade] = []
    for i, table in enumerate(tables):
        try:
            grade = _build_grade(SECTIONS[section], table)
            names = [NONE, *(other.name for other in grades)]
            is_new = bool(grade.name.strip()) and grade.name not in names
            expect(is_new, "name", grade.name, f"a name other than {', '.join(map(repr, names))}")
        except InvalidValue as error:
            raise error.prefix_key(f"{section}[{i}]") from None
        grades.append(grade)
    return tuple(grades)


def _build_grade(cls: type[Any], table: Any) -> Grade:
    if not isinstance(table, Mapping):
        raise InvalidValue("entry", table, "expected a table")
    cost_keys = tuple(get_fields(GradeCost))
    instrument_keys = [key for key in get_fields(cls) if key not in _MOUNTING_KEYS]
    for key, value in table.items():
        if key not in cost_keys and key not in instrument_keys:
            raise InvalidKey(
                str(key),
                value,
                f"unknown key{format_known_names(key, [*cost_keys, *instrument_keys])}",
            )
    cost = GradeCost(**{key: table[key] for key in table if key in cost_keys})
    return Grade(cost, cls(**{key: table[key] for key in table if key not in cost_keys}))


def _validate_faces(faces: Any) -> tuple[str, ...]:
    is_known = isinstance(faces, list | tuple) and all(face in FACES for face in faces)
    is_valid = is_known and len(set(faces)) == len(faces)
    expect(is_valid, "faces", faces, f"a list of {', '.join(map(repr, FACES))}, each once")
    return tuple(faces)


def _validate_traits(section: str, grades: tuple[Grade, ...]) -> None:
    """Raise InvalidValue if grades of one instrument cannot share a compiled Kalman filter.

    The grades must agree in all properties that are compiled into the filter, such as their error
    states.
    """
    for i, grade in enumerate(grades[1:], 1):
        first_traits, traits = (_list_kernel_traits(g.instrument) for g in (grades[0], grade))
        for name, value in traits.items():
            expected = f"{first_traits[name]!r}, as in {section}[0]"
            expect(value == first_traits[name], f"{section}[{i}], {name}", value, expected)


def _list_kernel_traits(instrument: Any) -> dict[str, Any]:
    """Return the properties of an instrument that are compiled into the Kalman filter."""
    cones = (
        instrument.list_visibility_cones() if hasattr(instrument, "list_visibility_cones") else ()
    )
    return {
        "states": list(instrument.states()),
        "sample_interval": getattr(instrument, "sample_interval", None),
        "considered": getattr(instrument, "considered", None),
        "exclusions and field of view": [cone.direction for cone in cones],
        "rate limit": getattr(instrument, "max_rate_deg_s", None) is not None,
    }
