"""Filter models of all suites of a catalog, with few compiled kernels.

A form is a filter model with a number of Sun sensors, with or without a star tracker. A suite is a
variant of a form: the parameters of its grades are inputs of the kernel, and the Sun sensors of a
form are not tied to faces. Designs of the same form are evaluated together.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from mgeo_attitude import FilterModel, Gyro, Scenario, Sensor, Suite
from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.evaluator import Evaluation, evaluate
from mgeo_attitude.settings.errors import InvalidValue

from mgeo_suite.catalog import FACES, NONE, Catalog, Grade

_MAX_CACHED_VARIANTS = 20_000  # cached variants; each has a suite and a few short arrays
RESOURCE_KEYS = ("price_keur", "mass_g", "power_mw")


@dataclass(frozen=True)
class MountingPlace:
    """Mounting place of an instrument, with its options.

    Attributes
    ----------
    name : str
        Name of the variable.
    options : tuple of str
        Names of grades, preceded by "none" if the instrument is optional.
    instruments : tuple
        Gyro or sensor of each option; None for "none".
    is_on_face : bool
        Whether the place is for a Sun sensor on a face. These places come last.
    resources : array, shape (n_options, 3)
        Price [kEUR], mass [g] and power [mW] of each option.
    """

    name: str
    options: tuple[str, ...]
    instruments: tuple[Any, ...]
    resources: Floats
    is_on_face: bool = False


class SuiteModels:
    """Filter models of all suites of a catalog in a scenario.

    A choice is an array of option indices, one for each of the `places`.
    """

    def __init__(self, scenario: Scenario, catalog: Catalog) -> None:
        self.catalog, self.places = catalog, tuple(list_places(catalog))
        gyro, *sensors = (place.instruments[-1] for place in self.places)
        self.scenario = _add_instruments(scenario, gyro, tuple(sensors))
        on_face: Bools = np.array([place.is_on_face for place in self.places])
        self._n_bus_places = int(np.sum(~on_face))
        # The number of a form has the count of Sun sensors as its lowest digit, and a bit for each
        # of the other places.
        self._form_weights: Ints = np.where(
            on_face, 1, (np.sum(on_face) + 1) << np.arange(len(on_face))
        )
        self._is_optional: Bools = np.array([place.options[0] == NONE for place in self.places])
        self._forms: dict[int, FilterModel] = {}
        self._variants: dict[bytes, FilterModel] = {}

    def __reduce__(self) -> tuple[type[SuiteModels], tuple[Scenario, Catalog]]:
        # A copy, in another process or a history, computes its models again.
        return SuiteModels, (self.scenario, self.catalog)

    @cached_property
    def model(self) -> FilterModel:
        """Form of the suite with all instruments."""
        return self.get_form(np.array([len(place.options) - 1 for place in self.places]))

    def compute_form_numbers(self, choices: Ints) -> Ints:
        """Return the form number of each choice, shape (n,), for choices of shape (n, n_places)."""
        return self._has_instrument(choices) @ self._form_weights

    def get_form(self, choice: Ints) -> FilterModel:
        """Return the form of a choice, shape (n_places,), computed on first use."""
        number = int(self.compute_form_numbers(choice))
        if number not in self._forms:
            filled, single = (
                self._has_instrument(choice),
                self._n_bus_places - 1,
            )  # sensors not on a face
            sensors, n_heads = self.scenario.sensors, np.sum(filled[self._n_bus_places :])
            own = [sensor for n, sensor in enumerate(sensors[:single]) if filled[1 + n]]
            own.extend(sensors[single : single + n_heads])
            scenario = dataclasses.replace(self.scenario, sensors=tuple(own))
            self._forms[number] = FilterModel.from_scenario(scenario, self._environment)
        return self._forms[number]

    def _has_instrument(self, choices: Ints) -> Bools:
        """Return which places of choices, shape (..., n_places), have an instrument."""
        return (choices > 0) | ~self._is_optional

    @cached_property
    def _environment(self) -> Environment:
        return Environment.from_scenario(self.scenario)

    def compute_resources(self, choices: Ints) -> Floats:
        """Return price [kEUR], mass [g] and power [mW] of choices (n, n_places), shape (n, 3)."""
        parts = [place.resources[choices[:, k]] for k, place in enumerate(self.places)]
        total: Floats = np.sum(parts, axis=0)
        return total

    def get_variant(self, choice: Ints) -> FilterModel:
        """Return the filter model of a choice, shape (n_places,)."""
        key = choice.tobytes()
        model = self._variants.get(key)
        if model is None:
            if len(self._variants) >= _MAX_CACHED_VARIANTS:
                self._variants.clear()
            model = self._variants[key] = self._build_variant(choice)
        return model

    def get_option_names(self, choice: Ints) -> dict[str, str]:
        """Return the option of each place by name."""
        return {
            place.name: place.options[number]
            for place, number in zip(self.places, choice, strict=True)
        }

    def describe_suite(self, choice: Ints) -> str:
        """Describe a suite, such as ``mems gyro, boom magnetometer, 1 fine Sun sensor (+x)``."""
        names = self.get_option_names(choice)
        parts = [f"{names['gyro']} gyro", f"{names['magnetometer']} magnetometer"]
        if (tracker := names.get("star tracker", NONE)) != NONE:
            parts.append(f"{tracker} star tracker")
        heads: dict[str, list[str]] = {}
        for place, grade in names.items():
            if place.startswith("Sun sensor") and grade != NONE:
                heads.setdefault(grade, []).append(place.removeprefix("Sun sensor "))
        for grade, faces in heads.items():
            many = "s" if len(faces) > 1 else ""
            parts.append(f"{len(faces)} {grade} Sun sensor{many} ({', '.join(faces)})")
        return ", ".join(parts)

    def _build_variant(self, choice: Ints) -> FilterModel:
        form = self.get_form(choice)
        chosen = (p.instruments[n] for p, n in zip(self.places, choice, strict=True))
        gyro, *sensors = (each for each in chosen if each is not None)
        named = zip(form.suite.sensors, sensors, strict=True)
        suite = Suite(
            gyro,
            tuple(_rename_sensor(sensor, place.name) for place, sensor in named),
            form.suite.environment_errors,
        )
        sigma = suite.initial_sigma(np.radians(self.scenario.initial.attitude_deg))
        return dataclasses.replace(form, suite=suite, initial_sigma=sigma)


@cache
def _rename_sensor(sensor: Sensor, name: str) -> Sensor:
    return sensor if sensor.name == name else dataclasses.replace(sensor, name=name)


def list_places(catalog: Catalog) -> Iterator[MountingPlace]:
    """Yield the places of all instruments in the order of the filter's states."""
    yield _build_place("gyro", catalog.gyros)
    yield _build_place("magnetometer", catalog.magnetometers, name="mag")
    if catalog.star_trackers:
        yield _build_place("star tracker", catalog.star_trackers, optional=True, name="tracker")
    if catalog.sun_sensors:
        for face in catalog.faces:
            name = f"sun_{face.replace('+', 'p').replace('-', 'n')}"
            where = {"name": name, "boresight": FACES[face]}
            place = _build_place(f"Sun sensor {face}", catalog.sun_sensors, optional=True, **where)
            yield dataclasses.replace(place, is_on_face=True)


def _build_place(
    variable: str, grades: Sequence[Grade], optional: bool = False, **mounting: Any
) -> MountingPlace:
    instruments = [dataclasses.replace(grade.instrument, **mounting) for grade in grades]
    resources = [[getattr(grade.cost, key) for key in RESOURCE_KEYS] for grade in grades]
    options = [grade.name for grade in grades]
    if optional:
        instruments, options = [None, *instruments], [NONE, *options]
        resources = [[0.0] * len(RESOURCE_KEYS), *resources]
    return MountingPlace(variable, tuple(options), tuple(instruments), np.array(resources))


def _add_instruments(scenario: Scenario, gyro: Gyro, sensors: tuple[Any, ...]) -> Scenario:
    """Return the scenario with all instruments of the catalog.

    Raises
    ------
    InvalidValue
        If a requirement or weight refers to an instrument that a suite may lack, or if the scenario
        has Monte Carlo runs.
    """
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
    if scenario.monte_carlo is not None:
        raise InvalidValue(
            "monte_carlo", "...", "expected none: suites are evaluated in the nominal run"
        )
    return dataclasses.replace(scenario, gyro=gyro, sensors=sensors)


def evaluate_choices(
    suites: SuiteModels, choices: Ints, maneuvers: Floats, threads: int | None, history: bool
) -> Evaluation:
    """Run the filter for n choices with their maneuvers, shape (n, 4 m).

    The results contain only the states that all forms share: attitude and gyro.
    """
    if not len(choices):
        return evaluate(suites.model, maneuvers, covariance=True)
    distinct, which = np.unique(choices, axis=0, return_inverse=True)
    forms, which = suites.compute_form_numbers(distinct), which.reshape(-1)
    parts = []
    for number in np.unique(forms):
        same = np.flatnonzero(forms == number)
        rows = np.flatnonzero(forms[which] == number)
        form = suites.get_form(distinct[same[0]])
        result = evaluate(
            form,
            maneuvers[rows],
            threads,
            history=history,
            covariance=True,
            variants=[suites.get_variant(choice) for choice in distinct[same]],
            variant_index=np.searchsorted(same, which[rows]),
        )
        parts.append((rows, _truncate_states(result, form.suite.n_kinematic)))
    return _concatenate_results(parts, suites, maneuvers)


def _truncate_states(result: Evaluation, n: int) -> Evaluation:
    return dataclasses.replace(
        result, covariance=result.covariance[:, :n, :n], variances=result.variances[..., :n]
    )


def _concatenate_results(
    parts: list[tuple[Ints, Evaluation]], suites: SuiteModels, maneuvers: Floats
) -> Evaluation:
    """Concatenate results in the order of their rows."""
    order = np.argsort(np.concatenate([rows for rows, _ in parts]))
    joined = {}
    for field in dataclasses.fields(Evaluation):
        values = [getattr(result, field.name) for _, result in parts]
        if isinstance(values[0], np.ndarray):
            stacked = np.concatenate(values)
            joined[field.name] = stacked[order] if len(stacked) else stacked
    return Evaluation(**joined, plan=suites.model.build_schedule(maneuvers))
