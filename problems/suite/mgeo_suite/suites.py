"""Filter models of all sensor suites of a catalog, with few compiled kernels.

A *layout* is the number of Sun sensors together with the presence of a star tracker. All suites of
a layout share one compiled kernel of the filter, because the error parameters and the boresights of
the sensors are inputs of the kernel. Designs of the same layout are evaluated together.
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

_MAX_CACHED_MODELS = 20_000  # cached filter models; each has a suite and a few short arrays
#: Fields of `GradeCost` that are summed over a suite.
RESOURCE_KEYS = ("price_keur", "mass_g", "power_mw")


@dataclass(frozen=True)
class MountingPlace:
    """Mounting place of an instrument, with the grades that can be selected.

    Attributes
    ----------
    name : str
        Name of the design variable.
    options : tuple of str
        Names of grades, preceded by "none" if the instrument is optional.
    instruments : tuple
        Gyro or sensor of each option, None for "none".
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
    """Filter models of all sensor suites that can be selected from a catalog.

    A *choice* is an array of shape (n_places,) with the index of the selected option of each
    mounting place. It identifies a suite.

    Parameters
    ----------
    scenario : Scenario
        Orbit, constraints and criteria. Its gyro and sensors are ignored.
    catalog : Catalog
        Grades of the instruments.

    Attributes
    ----------
    places : tuple of MountingPlace
        Mounting places, in the order of the states of the filter.
    scenario : Scenario
        Scenario with the last grade of each instrument of the catalog.

    Raises
    ------
    InvalidValue
        If the scenario has Monte Carlo runs, or criteria of sensors that a suite may lack.
    """

    def __init__(self, scenario: Scenario, catalog: Catalog) -> None:
        self.catalog, self.places = catalog, tuple(list_places(catalog))
        gyro, *sensors = (place.instruments[-1] for place in self.places)
        self.scenario = _add_instruments(scenario, gyro, tuple(sensors))
        on_face: Bools = np.array([place.is_on_face for place in self.places])
        self._n_bus_places = int(np.sum(~on_face))
        # The ID of a layout is the number of Sun sensors, plus a bit for each of the other places.
        self._layout_weights: Ints = np.where(
            on_face, 1, (np.sum(on_face) + 1) << np.arange(len(on_face))
        )
        self._is_optional: Bools = np.array([place.options[0] == NONE for place in self.places])
        self._layout_models: dict[int, FilterModel] = {}
        self._suite_models: dict[bytes, FilterModel] = {}

    def __reduce__(self) -> tuple[type[SuiteModels], tuple[Scenario, Catalog]]:
        # A pickled copy, for example in another process, rebuilds its models.
        return SuiteModels, (self.scenario, self.catalog)

    @cached_property
    def model(self) -> FilterModel:
        """Filter model of the largest suite, with an instrument at every mounting place."""
        return self.get_layout_model(np.array([len(place.options) - 1 for place in self.places]))

    def compute_layout_ids(self, choices: Ints) -> Ints:
        """Return an integer that is equal for suites with equal numbers of sensors of each kind.

        Suites with the same integer share a compiled Kalman filter. The integer encodes the number
        of Sun sensors and the presence of a star tracker.

        Parameters
        ----------
        choices : array of int, shape (..., n_places)
            Index of the selected option of each mounting place.

        Returns
        -------
        array of int, shape (...)
        """
        return self._has_instrument(choices) @ self._layout_weights

    def get_layout_model(self, choice: Ints) -> FilterModel:
        """Return a filter model with as many sensors of each kind as the selected suite.

        Suites with equal numbers of sensors of each kind share the model and its compiled Kalman
        filter. The model is built on first use. Its sensors have the errors of the last grade in
        the catalog.

        Parameters
        ----------
        choice : array of int, shape (n_places,)
            Index of the selected option of each mounting place.
        """
        layout_id = int(self.compute_layout_ids(choice))
        if layout_id not in self._layout_models:
            is_filled, all_sensors = self._has_instrument(choice), self.scenario.sensors
            n_bus_sensors = self._n_bus_places - 1  # all places but the gyro and the faces
            n_sun_sensors = np.sum(is_filled[self._n_bus_places :])
            sensors = [s for n, s in enumerate(all_sensors[:n_bus_sensors]) if is_filled[1 + n]]
            sensors.extend(all_sensors[n_bus_sensors : n_bus_sensors + n_sun_sensors])
            scenario = dataclasses.replace(self.scenario, sensors=tuple(sensors))
            self._layout_models[layout_id] = FilterModel.from_scenario(scenario, self._environment)
        return self._layout_models[layout_id]

    def _has_instrument(self, choices: Ints) -> Bools:
        """Return a boolean array that is True at the mounting places with an instrument."""
        return (choices > 0) | ~self._is_optional

    @cached_property
    def _environment(self) -> Environment:
        return Environment.from_scenario(self.scenario)

    def compute_resources(self, choices: Ints) -> Floats:
        """Return the price, mass and power of suites, summed over their instruments.

        Parameters
        ----------
        choices : array of int, shape (n, n_places)
            Index of the selected option of each mounting place.

        Returns
        -------
        array, shape (n, 3)
            Price [kEUR], mass [g] and power [mW].
        """
        parts = [place.resources[choices[:, k]] for k, place in enumerate(self.places)]
        total: Floats = np.sum(parts, axis=0)
        return total

    def get_suite_model(self, choice: Ints) -> FilterModel:
        """Return the filter model of a suite.

        The model is built on first use.

        Parameters
        ----------
        choice : array of int, shape (n_places,)
            Index of the selected option of each mounting place.
        """
        key = choice.tobytes()
        model = self._suite_models.get(key)
        if model is None:
            if len(self._suite_models) >= _MAX_CACHED_MODELS:
                self._suite_models.clear()
            model = self._suite_models[key] = self._build_suite_model(choice)
        return model

    def get_option_names(self, choice: Ints) -> dict[str, str]:
        """Return a dict that maps mounting places to the names of the selected grades."""
        return {
            place.name: place.options[number]
            for place, number in zip(self.places, choice, strict=True)
        }

    def describe_suite(self, choice: Ints) -> str:
        """Return a text that lists the gyro and the sensors of a suite.

        An example is ``mems gyro, boom magnetometer, 1 fine Sun sensor (+x)``.
        """
        names = self.get_option_names(choice)
        parts = [f"{names['gyro']} gyro", f"{names['magnetometer']} magnetometer"]
        if (tracker := names.get("star tracker", NONE)) != NONE:
            parts.append(f"{tracker} star tracker")
        faces_by_grade: dict[str, list[str]] = {}
        for place, grade in names.items():
            if place.startswith("Sun sensor") and grade != NONE:
                faces_by_grade.setdefault(grade, []).append(place.removeprefix("Sun sensor "))
        for grade, faces in faces_by_grade.items():
            plural = "s" if len(faces) > 1 else ""
            parts.append(f"{len(faces)} {grade} Sun sensor{plural} ({', '.join(faces)})")
        return ", ".join(parts)

    def _build_suite_model(self, choice: Ints) -> FilterModel:
        layout_model = self.get_layout_model(choice)
        selected = (p.instruments[n] for p, n in zip(self.places, choice, strict=True))
        gyro, *sensors = (instrument for instrument in selected if instrument is not None)
        pairs = zip(layout_model.suite.sensors, sensors, strict=True)
        suite = Suite(
            gyro,
            tuple(_rename_sensor(sensor, place.name) for place, sensor in pairs),
            layout_model.suite.environment_errors,
        )
        sigma = suite.initial_sigma(np.radians(self.scenario.initial.attitude_deg))
        return dataclasses.replace(layout_model, suite=suite, initial_sigma=sigma)


@cache
def _rename_sensor(sensor: Sensor, name: str) -> Sensor:
    return sensor if sensor.name == name else dataclasses.replace(sensor, name=name)


def list_places(catalog: Catalog) -> Iterator[MountingPlace]:
    """Yield the mounting places of all instruments, in the order of the filter states.

    Parameters
    ----------
    catalog : Catalog
        Grades of the instruments, which become the options of the places.
    """
    yield _build_place("gyro", catalog.gyros)
    yield _build_place("magnetometer", catalog.magnetometers, name="mag")
    if catalog.star_trackers:
        yield _build_place("star tracker", catalog.star_trackers, optional=True, name="tracker")
    if catalog.sun_sensors:
        for face in catalog.faces:
            name = f"sun_{face.replace('+', 'p').replace('-', 'n')}"
            mounting = {"name": name, "boresight": FACES[face]}
            place = _build_place(
                f"Sun sensor {face}", catalog.sun_sensors, optional=True, **mounting
            )
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
    """Return a copy of a scenario with the given gyro and sensors.

    Raises
    ------
    InvalidValue
        If a requirement or a weight refers to a sensor that a suite may lack, or if the scenario
        has Monte Carlo runs.
    """
    common_prefixes = ("attitude", "gyro.", "mag.")
    for section in ("required_sigma", "trace_weights"):
        for key, value in getattr(scenario, section).items():
            if not key.startswith(common_prefixes):
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
    """Run the Kalman filter for each design with the selected suite and maneuvers.

    Parameters
    ----------
    suites : SuiteModels
        Filter models of the suites.
    choices : array of int, shape (n, n_places)
        Index of the selected option of each mounting place.
    maneuvers : array, shape (n, 4 n_maneuvers)
        Body rates [deg/s] and duration [s] of each maneuver.
    threads : int, optional
        Number of threads.
    history : bool
        Whether to include the variances after each step.

    Returns
    -------
    Evaluation
        Results in the order of the designs, with the covariance of the states that all suites have:
        attitude and gyro.
    """
    if not len(choices):
        return evaluate(suites.model, maneuvers, covariance=True)
    distinct, inverse = np.unique(choices, axis=0, return_inverse=True)
    layout_ids, inverse = suites.compute_layout_ids(distinct), inverse.reshape(-1)
    parts = []
    for layout_id in np.unique(layout_ids):
        same_layout = np.flatnonzero(layout_ids == layout_id)
        rows = np.flatnonzero(layout_ids[inverse] == layout_id)
        layout_model = suites.get_layout_model(distinct[same_layout[0]])
        result = evaluate(
            layout_model,
            maneuvers[rows],
            threads,
            history=history,
            covariance=True,
            variants=[suites.get_suite_model(choice) for choice in distinct[same_layout]],
            variant_index=np.searchsorted(same_layout, inverse[rows]),
        )
        parts.append((rows, _truncate_states(result, layout_model.suite.n_kinematic)))
    return _concatenate_results(parts, suites, maneuvers)


def _truncate_states(result: Evaluation, n: int) -> Evaluation:
    return dataclasses.replace(
        result, covariance=result.covariance[:, :n, :n], variances=result.variances[..., :n]
    )


def _concatenate_results(
    parts: list[tuple[Ints, Evaluation]], suites: SuiteModels, maneuvers: Floats
) -> Evaluation:
    """Concatenate the filter results of several batches, in the original order of the designs."""
    order = np.argsort(np.concatenate([rows for rows, _ in parts]))
    arrays = {}
    for field in dataclasses.fields(Evaluation):
        values = [getattr(result, field.name) for _, result in parts]
        if isinstance(values[0], np.ndarray):
            stacked = np.concatenate(values)
            arrays[field.name] = stacked[order] if len(stacked) else stacked
    return Evaluation(**arrays, plan=suites.model.build_schedule(maneuvers))
