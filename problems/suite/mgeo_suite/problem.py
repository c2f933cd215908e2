"""Joint selection of a sensor suite and its calibration maneuvers, as a pymoo problem."""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from mgeo_attitude import Evaluation, Scenario
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.constraints import list_constraints, validate_initial_state
from mgeo_attitude.criteria.evaluation_cache import EvaluationCache
from mgeo_attitude.maneuvers.schedule import decode_designs
from mgeo_attitude.settings.errors import InvalidKey, InvalidValue, format_known_names
from numpy.typing import ArrayLike
from pymoo.core.problem import Problem
from pymoo.core.variable import Choice, Real

from mgeo.plugins.protocol import ProblemMixin
from mgeo_suite.catalog import Catalog
from mgeo_suite.objectives import OBJECTIVES, SuiteObjective, validate_objectives
from mgeo_suite.suites import MountingPlace, SuiteModels, evaluate_choices

if TYPE_CHECKING:
    from mgeo_suite.view import SuiteView

#: Objectives of each preset. All presets have the scenario of ``cubesat.toml``.
PRESETS: Mapping[str, tuple[str, ...]] = {
    "cubesat": ("price", "attitude"),
    "cubesat_time": ("price", "attitude", "t_end"),
}
_OPTION_KEYS = ("preset", "scenario", "catalog", "objectives")


def load_scenario_table() -> dict[str, Any]:
    """Return the default CubeSat scenario as nested dicts, which `Scenario.from_dict` accepts."""
    text = Path(__file__).with_name("cubesat.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


class SensorSuiteProblem(ProblemMixin, Problem):
    """Problem of selecting sensors and calibration maneuvers that minimize cost and error.

    The cost is the price, mass or power of the suite. The error is the attitude 1-sigma after the
    maneuvers. The first variables are pymoo's `Choice` of a grade of gyro, magnetometer, star
    tracker (or none), and Sun sensor on each face (or none). The others are the real variables of
    the maneuvers, as in `mgeo_attitude.AttitudeManeuverProblem`: body rates ωx, ωy, ωz [deg/s] and
    duration [s] of each maneuver. A design is a dict that maps variable names to values, or a row
    of numbers in which a choice is the index of its option. The constraints of the scenario are
    inequality constraints, see `constraint_names`.

    Parameters
    ----------
    scenario : Scenario, optional
        Orbit, constraints and criteria. Its gyro and sensors are ignored. Default: a CubeSat in the
        orbit of `Scenario.cubesat_6u`, with one orbit for the calibration.
    catalog : Catalog, optional
        Grades of the instruments. Default: `Catalog.default()`.
    objectives : sequence of str
        Names of the objectives, from "price", "mass", "power", "attitude" (attitude 1-sigma after
        the calibration), "t_end", "t_required" and "trace".
    threads : int, optional
        Number of threads of an evaluation, on which the results do not depend. Default: the number
        of processors available to the process.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or an objective is unknown, or if the scenario has Monte
        Carlo runs, requirements on sensors that a suite may lack, or an initial state that violates
        a constraint.

    Examples
    --------
    >>> from mgeo_suite import SensorSuiteProblem
    >>> problem = SensorSuiteProblem(objectives=("price", "attitude", "t_end"))
    >>> problem.n_obj, list(problem.vars)[:4]
    (3, ['gyro', 'magnetometer', 'star tracker', 'Sun sensor +x'])
    """

    var_names: tuple[str, ...]
    without_effect = ("threads",)
    preset_descriptions: ClassVar[Mapping[str, str]] = {
        "cubesat": "minimizes price and attitude 1-sigma; the default",
        "cubesat_time": "minimizes price, attitude 1-sigma and plan duration",
    }

    def __init__(
        self,
        scenario: Scenario | None = None,
        catalog: Catalog | None = None,
        objectives: Sequence[str] = PRESETS["cubesat"],
        threads: int | None = None,
    ) -> None:
        scenario = Scenario.from_dict(load_scenario_table()) if scenario is None else scenario
        catalog = Catalog.default() if catalog is None else catalog
        for name, value, kind in (("scenario", scenario, Scenario), ("catalog", catalog, Catalog)):
            if not isinstance(value, kind):
                raise TypeError(f"{name} = {value!r:.80}: expected a {kind.__name__}")
        if threads is not None and (not isinstance(threads, int) or threads < 1):
            raise ValueError(f"threads = {threads!r}: expected an integer >= 1, or None")
        self.objectives = validate_objectives(objectives, bool(scenario.required_sigma))
        self.catalog, self.threads = catalog, threads
        self.suites = SuiteModels(scenario, catalog)
        self.scenario = self.suites.scenario
        validate_initial_state(self.scenario)
        self._cache = EvaluationCache()
        self._constraints = list_constraints(self.scenario)
        self.obj_names = tuple(objective.label for objective in self._list_objectives())
        self.obj_labels = self.objectives
        self.constraint_names = tuple(constraint.label for constraint in self._constraints)
        variables = {
            place.name: Choice(options=list(place.options)) for place in self.suites.places
        }
        limits = self.scenario.maneuvers
        max_rate, max_duration = limits.max_rate_deg_s, limits.max_duration
        for m in range(1, limits.count + 1):
            for axis in "xyz":
                variables[f"omega_{axis}_{m} [deg/s]"] = Real(bounds=(-max_rate, max_rate))
            variables[f"duration_{m} [s]"] = Real(bounds=(0.0, max_duration))
        self.var_names = tuple(variables)
        super().__init__(
            vars=variables, n_obj=len(self.objectives), n_ieq_constr=len(self.constraint_names)
        )

    def split_designs(self, X: ArrayLike) -> tuple[Ints, Floats]:
        """Split designs into the selected instruments and the maneuver variables.

        Parameters
        ----------
        X : array_like, shape (n, n_var) or (n,)
            Designs as numbers or as dicts.

        Returns
        -------
        choices : array of int, shape (n, n_places)
            Index of the selected option of each mounting place.
        maneuvers : array, shape (n, 4 n_maneuvers)
            Body rates [deg/s] and duration [s] of each maneuver.

        Raises
        ------
        TypeError, ValueError
            If a design is neither a dict of the variables nor numbers, or an option does not exist.
        """
        n_places, numbers = len(self.suites.places), self.encode_designs(X)
        with np.errstate(invalid="ignore"):  # NaN is reported as an error below.
            choices = numbers[:, :n_places].astype(np.int64)
        for j, place in enumerate(self.suites.places):
            is_invalid = (numbers[:, j] != choices[:, j]) | (choices[:, j] < 0)
            is_invalid |= choices[:, j] >= len(place.options)
            if is_invalid.any():
                raise ValueError(
                    f"{place.name} = {numbers[is_invalid][0, j]}: expected an integer from 0 "
                    f"to {len(place.options) - 1}, which selects one of {', '.join(place.options)}"
                )
        return choices, numbers[:, n_places:]

    def run_filter(self, X: ArrayLike, history: bool = False) -> Evaluation:
        """Run the Kalman filter for each design with the sensors of its suite.

        Parameters
        ----------
        X : array_like, shape (n, n_var) or (n,)
            Designs as numbers or as dicts.
        history : bool
            Whether to include the variances after each step.

        Returns
        -------
        Evaluation
            Results with the covariance of the states that all suites have: attitude and gyro.
        """
        return evaluate_choices(self.suites, *self.split_designs(X), self.threads, history)

    def _evaluate(self, X: Any, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        numbers = self.encode_designs(X)
        # An error names the index of an invalid design in the whole batch, not in a part of it.
        decode_designs(self.split_designs(numbers)[1])
        values = self._cache.evaluate(numbers, self._compute_values)
        out["F"], out["G"] = np.split(values, [self.n_obj], axis=1)

    def _compute_values(self, designs: Floats) -> Floats:
        """Return the objectives and constraint violations of designs, with one row per design."""
        result = self.run_filter(designs)
        resources = self.suites.compute_resources(self.split_designs(designs)[0])
        columns = [
            objective.value(self.suites.model, result, resources)
            for objective in self._list_objectives()
        ]
        columns += [
            constraint.compute_violations(result).max(axis=0) for constraint in self._constraints
        ]
        return np.column_stack(columns)

    def _list_objectives(self) -> list[SuiteObjective]:
        return [OBJECTIVES[name] for name in self.objectives]

    def encode_designs(self, X: ArrayLike) -> Floats:
        """Convert mixed-variable designs from dicts to rows of numbers.

        Designs that are numbers already are returned as a float array.

        Parameters
        ----------
        X : array_like, shape (n, n_var) or (n,)
            Designs as numbers, or as dicts that map variable names to values.

        Returns
        -------
        array, shape (n, n_var)
            Designs in which a selected option is represented by its index.

        Raises
        ------
        ValueError
            If a dict lacks a variable or has an unknown option, or the array has another shape.
        """
        designs = np.asarray(X)
        if designs.dtype == object and designs.ndim == 1:
            rows = []
            for design in designs:
                if not isinstance(design, Mapping) or not design.keys() >= set(self.var_names):
                    raise ValueError(f"{design!r:.80}: expected a dict of {list(self.var_names)}")
                row = [
                    _find_option_index(place, design[place.name]) for place in self.suites.places
                ]
                rows.append(row + [design[name] for name in self.var_names[len(row) :]])
            designs = np.array(rows, dtype=float).reshape(-1, self.n_var)
        numbers = np.atleast_2d(designs.astype(float))
        if numbers.ndim != 2 or numbers.shape[1] != self.n_var:
            raise ValueError(f"X of shape {np.shape(X)}: expected (n, {self.n_var})")
        return numbers

    @classmethod
    def from_options(cls, options: Mapping[str, Any]) -> SensorSuiteProblem:
        """Construct the problem from options: a preset, a scenario, a catalog and objectives.

        Parameters
        ----------
        options : mapping
            ``preset``, a name in `PRESETS`; ``scenario`` and ``catalog``, tables for
            `Scenario.from_dict` and `Catalog.from_dict`; and ``objectives``, a list of names. All
            are optional.

        Raises
        ------
        InvalidValue
            (ValueError) If a key is unknown or a value is invalid. The message names the key.
        """
        for key, value in options.items():
            if key not in _OPTION_KEYS:
                raise InvalidKey(
                    str(key), value, f"unknown key{format_known_names(key, _OPTION_KEYS)}"
                )
        preset = options.get("preset", "cubesat")
        if not isinstance(preset, str) or preset not in PRESETS:
            raise InvalidValue(
                "preset", preset, f"unknown preset{format_known_names(preset, PRESETS)}"
            )
        for key in ("scenario", "catalog"):
            if not isinstance(options.get(key, {}), Mapping):
                raise InvalidValue(key, options[key], "expected a table")
        arguments: dict[str, Any] = {"objectives": options.get("objectives", PRESETS[preset])}
        for key, from_dict in (("scenario", Scenario.from_dict), ("catalog", Catalog.from_dict)):
            try:
                arguments[key] = from_dict(options[key]) if key in options else None
            except InvalidValue as error:
                raise error.prefix_key(key) from None
        return cls(**arguments)

    @classmethod
    def read_files(cls, options: Mapping[str, Any], folder: Path) -> dict[str, Any]:
        """Replace the paths of scenario and catalog files by the contents of these files.

        Parameters
        ----------
        options : mapping
            Options of a scenario file, see `from_options`.
        folder : Path
            Folder to which the file names are relative.

        Raises
        ------
        ValueError, OSError
            If a file is invalid or cannot be read.
        """
        result = dict(options)
        if isinstance(name := result.get("scenario"), str):
            result["scenario"] = Scenario.from_toml(folder / name).to_dict()
        if isinstance(name := result.get("catalog"), str):
            result["catalog"] = Catalog.from_toml(folder / name).to_dict()
        return result

    def to_options(self) -> dict[str, Any]:
        """Return scenario, catalog and objectives as a JSON dict, which `from_options` accepts."""
        scenario = dataclasses.replace(
            self.scenario,
            gyro=self.suites.places[0].instruments[0],
            sensors=(self.suites.places[1].instruments[0],),  # placeholder, which is ignored
        )
        return {
            "scenario": scenario.to_dict(),
            "catalog": self.catalog.to_dict(),
            "objectives": list(self.objectives),
        }

    def map_to_indicator_space(self, F: ArrayLike) -> Floats:
        """Scale objectives to order 1 for performance indicators such as the hypervolume.

        Price, mass and power are divided by their maximum over all suites. The attitude 1-sigma is
        mapped to the decimal logarithm of its ratio to 0.001 deg, divided by four. All other
        objectives are scaled as in `mgeo_attitude.AttitudeManeuverProblem`.

        Parameters
        ----------
        F : array_like, shape (n, n_obj)
            Objectives.

        Returns
        -------
        array, shape (n, n_obj)
        """
        maximum = np.sum([place.resources.max(axis=0) for place in self.suites.places], axis=0)
        maximum = np.where(maximum > 0.0, maximum, 1.0)
        values = np.atleast_2d(np.asarray(F, dtype=float))
        columns = [
            objective.indicator(column, self.scenario, maximum)
            for objective, column in zip(self._list_objectives(), values.T, strict=True)
        ]
        return np.column_stack(columns)

    def view(self, X: ArrayLike) -> SuiteView:
        """Return a `SuiteView`, which presents designs in tables, figures and reports."""
        from mgeo_suite.view import SuiteView

        return SuiteView(self, X)


def _find_option_index(place: MountingPlace, option: Any) -> int:
    if option not in place.options:
        known = format_known_names(str(option), place.options)
        raise InvalidValue(place.name, option, f"unknown option{known}")
    return place.options.index(option)
