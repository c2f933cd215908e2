"""Suites of a catalog as variants of a few filter models, so that few kernels serve all of them.

A form is a filter model with room for so many Sun sensors; a suite is a variant of the smallest one
that has room for it, in which its Sun sensors come first and no place is a face's own.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from mgeo_attitude import FilterModel, Gyro, Scenario, Sensor, Suite
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.environment import Environment
from mgeo_attitude.fields import InvalidValue

from mgeo_suite.catalog import NONE, Catalog, Grade
from mgeo_suite.heads import FACES, Absent, NoStarTracker, NoSunHead

_ROOM = (1, 3)  # Sun sensors of the smaller forms; a kernel of many states costs much a step
_MOST_KEPT = 20_000  # variants of a search; each has a suite and three short arrays
RESOURCES = ("price_keur", "mass_g", "power_mw")


@dataclass(frozen=True)
class Place:
    """Where an instrument is chosen: its name as a variable, and the options.

    Attributes
    ----------
    name : str
        Of the variable.
    options : tuple of str
        Names of grades, "none" before them where there need not be one.
    instruments : tuple
        The gyro or sensor of each option; that of "none" is an absent one, with the same states.
    on_face : bool
        Whether it is one of the places of Sun sensors, which come last.
    resources : array, shape (n_options, 3)
        Price [kEUR], mass [g] and power [mW] of each option.
    """

    name: str
    options: tuple[str, ...]
    instruments: tuple[Any, ...]
    resources: Floats
    on_face: bool = False


class SuiteModels:
    """The filter models of all suites of a catalog in a scenario.

    A choice is an array of the numbers of options, one for each of the `places`.
    """

    def __init__(self, scenario: Scenario, catalog: Catalog) -> None:
        self.places = tuple(places(catalog))
        gyro, *sensors = (place.instruments[-1] for place in self.places)
        self.scenario = _complete(scenario, gyro, tuple(sensors))
        self._n_single = sum(not place.on_face for place in self.places)
        self._known: dict[bytes, FilterModel] = {}

    @cached_property
    def forms(self) -> list[FilterModel]:
        """By ascending number of Sun sensors; computed when first needed."""
        faces = len(self.places) - self._n_single
        environment = Environment.from_scenario(self.scenario)
        sizes = sorted({min(size, faces) for size in (*_ROOM, faces)})
        single = self._n_single - 1  # sensors that are on no face: all but the gyro
        scenarios = [
            dataclasses.replace(self.scenario, sensors=self.scenario.sensors[: single + size])
            for size in sizes
        ]
        return [FilterModel.from_scenario(each, environment) for each in scenarios]

    @property
    def model(self) -> FilterModel:
        """The form of the complete suite."""
        return self.forms[-1]

    def form(self, choices: Ints) -> Ints:
        """The number of the form that each choice (n, n_places) is a variant of, shape (n,)."""
        first = self._n_single - 1
        room = [len(model.suite.sensors) - first for model in self.forms]
        heads = np.count_nonzero(choices[:, self._n_single :], axis=1)
        form: Ints = np.searchsorted(room, heads)
        return form

    @cached_property
    def n_common(self) -> int:
        """States of attitude, gyro, magnetometer and star tracker, which all forms begin with."""
        sensors = self.scenario.sensors[: self._n_single - 1]
        return Suite(self.scenario.gyro, sensors).n_states

    def resources(self, choices: Ints) -> Floats:
        """Price [kEUR], mass [g] and power [mW] of choices (n, n_places), shape (n, 3)."""
        parts = [place.resources[choices[:, k]] for k, place in enumerate(self.places)]
        total: Floats = np.sum(parts, axis=0)
        return total

    def variants(self, choices: Ints) -> tuple[list[FilterModel], Ints]:
        """The models of choices (n, n_places) of one form, each once, and the number of each's."""
        distinct, which = np.unique(choices, axis=0, return_inverse=True)
        return [self.variant(choice) for choice in distinct], which.reshape(-1)

    def variant(self, choice: Ints) -> FilterModel:
        """The model of a choice, shape (n_places,)."""
        key = choice.tobytes()
        found = self._known.get(key)
        if found is None:
            if len(self._known) >= _MOST_KEPT:
                self._known.clear()
            found = self._known[key] = self._made(choice)
        return found

    def names(self, choice: Ints) -> dict[str, str]:
        """The option of each place."""
        return {
            place.name: place.options[number]
            for place, number in zip(self.places, choice, strict=True)
        }

    def _made(self, choice: Ints) -> FilterModel:
        model = self.forms[int(self.form(choice[None])[0])]
        gyro, *sensors = (p.instruments[i] for p, i in zip(self.places, choice, strict=True))
        heads = sensors[self._n_single - 1 :]
        heads.sort(key=lambda head: isinstance(head, Absent))  # stable: the others keep their order
        sensors = [*sensors[: self._n_single - 1], *heads][: len(model.suite.sensors)]
        named = zip(model.suite.sensors, sensors, strict=True)
        suite = Suite(gyro, tuple(_called(sensor, place.name) for place, sensor in named))
        there = np.ones(suite.n_states, dtype=bool)
        for sensor in suite.sensors:
            if isinstance(sensor, Absent):
                for first in suite.places(sensor).values():
                    there[first : first + 3] = False
        return dataclasses.replace(
            model,
            suite=suite,
            initial_sigma=suite.initial_sigma(np.radians(self.scenario.initial.attitude_deg)),
            weights=np.where(there, model.weights, 0.0),
            required_sigma=np.where(there, model.required_sigma, np.inf),
        )


@cache
def _called(sensor: Sensor, name: str) -> Sensor:
    return sensor if sensor.name == name else dataclasses.replace(sensor, name=name)


def places(catalog: Catalog) -> Iterator[Place]:
    """Gyro, magnetometer, star tracker and a Sun sensor a face, in the order of the filter."""
    yield _place("gyro", catalog.gyros)
    yield _place("magnetometer", catalog.magnetometers, name="mag")
    if catalog.star_trackers:
        yield _place("star tracker", catalog.star_trackers, NoStarTracker, name="tracker")
    if catalog.sun_sensors:
        for face in catalog.faces:
            name = f"sun_{face.replace('+', 'p').replace('-', 'n')}"
            where = {"name": name, "boresight": FACES[face]}
            place = _place(f"Sun sensor {face}", catalog.sun_sensors, NoSunHead, **where)
            yield dataclasses.replace(place, on_face=True)


def _place(
    variable: str, grades: Sequence[Grade], absent: type[Any] | None = None, **where: Any
) -> Place:
    instruments = [dataclasses.replace(grade.instrument, **where) for grade in grades]
    resources = [[getattr(grade.entry, key) for key in RESOURCES] for grade in grades]
    options = [grade.name for grade in grades]
    if absent is not None:
        values = {f.name: getattr(instruments[0], f.name) for f in dataclasses.fields(absent)}
        instruments, options = [absent(**values), *instruments], [NONE, *options]
        resources = [[0.0] * len(RESOURCES), *resources]
    return Place(variable, tuple(options), tuple(instruments), np.array(resources))


def _complete(scenario: Scenario, gyro: Gyro, sensors: tuple[Any, ...]) -> Scenario:
    """The scenario with all instruments of the catalog, if what it asks for fits any suite."""
    always = ("attitude", "gyro.", "mag.")
    for section in ("required_sigma", "trace_weights"):
        for key, value in getattr(scenario, section).items():
            if not key.startswith(always):
                raise InvalidValue(
                    f"{section}.{key}",
                    value,
                    "expected a state of the attitude, the gyro or the magnetometer 'mag', which "
                    "every suite has",
                )
    if scenario.flight is not None:
        raise InvalidValue(
            "flight", "...", "expected none: suites are judged by plans that are flown exactly"
        )
    return dataclasses.replace(scenario, gyro=gyro, sensors=sensors)
