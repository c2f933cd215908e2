"""Study files: problems, algorithms, budget and seeds in TOML."""

from __future__ import annotations

import json
import re
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from pymoo.core.algorithm import Algorithm
from pymoo.core.problem import Problem

from mgeo.benchmarks.collections import expand_name, format_short_name
from mgeo.plugins.problems import load_problem, read_scenario
from mgeo.runs.algorithms import build_algorithm, complete_parameters
from mgeo.store.readers import read_text
from mgeo.studies.schema import AlgorithmTable, ProblemTable, StudySettings, StudyTable
from mgeo.validation.arguments import validate_integer
from mgeo.validation.entries import convert_file_errors
from mgeo.validation.tables import validate_table


@dataclass(frozen=True)
class ProblemConfiguration:
    """Name, options and label of one problem of a study."""

    label: str
    name: str
    options: dict[str, Any]
    parts: tuple[float, ...] | None = None

    def build(self) -> Problem:
        """Build the problem of a plugin or of a collection, such as ``pymoo:zdt1``.

        Raises
        ------
        ValueError, TypeError
            If there is no such problem, or an option is invalid.
        """
        return load_problem(self.name, self.options, trusted_classes=(self.name,))


@dataclass(frozen=True)
class AlgorithmConfiguration:
    """Name, parameters and label of one algorithm of a study."""

    label: str
    name: str
    parameters: dict[str, Any]

    def build(self, problem: Problem) -> Algorithm:
        """Build the algorithm for a problem.

        Raises
        ------
        ValueError, TypeError
            If a parameter is invalid or the algorithm cannot solve the problem. The message begins
            with the label.
        """
        try:
            return build_algorithm(self.name, self.parameters, problem)
        except (ValueError, TypeError) as error:
            kind = TypeError if isinstance(error, TypeError) else ValueError
            raise kind(f"{self.label}: {error}") from error


class Study(StudySettings):
    """Validated content of a study file.

    Attributes
    ----------
    title, description : title and introduction of the report page.
    evaluations : evaluations of each run.
    per_variable : whether `evaluations` and `grid` are multiplied by the number of variables.
    seeds : seeds of the runs; each algorithm runs with each seed on each problem.
    grid : number of equal steps, or evaluation counts, at which fronts are measured.
    control : label of the control algorithm, which is compared with each other algorithm, or None.
    problems, algorithms : configurations of the problems and algorithms.
    published : published values to list beside the results, or None.
    text : content of the file.

    Examples
    --------
    >>> from pathlib import Path
    >>> from mgeo.studies import read_study
    >>> text = '''
    ... title = "Two algorithms"
    ... evaluations = 200
    ... seeds = [1, 2]
    ... problems = [{name = "pymoo:zdt1"}]
    ... algorithms = [{name = "mgeo-directed"}, {name = "nsga2"}]
    ... '''
    >>> _ = Path("study.toml").write_text(text)
    >>> study = read_study("study.toml")
    >>> study.seeds, [each.label for each in study.algorithms]
    ((1, 2), ['mgeo-directed', 'nsga2'])
    """

    problems: tuple[ProblemConfiguration, ...]
    algorithms: tuple[AlgorithmConfiguration, ...]
    text: str

    def build_plan(self) -> dict[str, Any]:
        """Return the problems, algorithms, budget and seeds as JSON values; dates are in ISO 8601.

        Raises
        ------
        ValueError
            If an option or a parameter is not finite.
        """
        plan = {
            "problems": {p.label: {"name": p.name, "options": p.options} for p in self.problems},
            "algorithms": {
                a.label: {"name": a.name, "parameters": a.parameters} for a in self.algorithms
            },
            "evaluations": self.evaluations,
            "per_variable": self.per_variable,
            "seeds": self.seeds,
        }
        text = json.dumps(plan, allow_nan=False, default=lambda day: day.isoformat())
        values: dict[str, Any] = json.loads(text)
        return values

    def compute_budget(self, problem: Problem) -> tuple[int, int | list[int]]:
        """Return the evaluations and the `grid` of a run on a problem."""
        each = problem.n_var if self.per_variable else 1
        if isinstance(self.grid, int):
            return self.evaluations * each, self.grid
        steps = [step * each for step in self.grid if step <= self.evaluations]
        return self.evaluations * each, steps

    def with_budget(self, evaluations: int | None = None, seeds: int | None = None) -> Study:
        """Return a copy with another number of evaluations or of seeds.

        Parameters
        ----------
        evaluations : evaluations of each run; None for no change.
        seeds : number of seeds, taken from the start of the list and continued by new seeds if the
            list is shorter; None for no change.

        Raises
        ------
        ValueError, TypeError
            If a number is not a positive integer.
        """
        changes: dict[str, Any] = {}
        if evaluations is not None:
            changes["evaluations"] = validate_integer("evaluations", evaluations, low=1)
        if seeds is not None:
            count = validate_integer("seeds", seeds, low=1)
            more = range(max(self.seeds) + 1, max(self.seeds) + 1 + count)
            changes["seeds"] = (*self.seeds, *more)[:count]
        return self.model_copy(update=changes)


def read_study(path: Path | str, *, allow_imports: bool = True) -> Study:
    """Read and validate a study file.

    Parameters
    ----------
    path : path of the TOML file.
    allow_imports : whether modules of algorithms and problems ``module:Class`` may be imported, so that
        their parameters are validated.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError, TypeError
        If the content is invalid. The message contains the file and the key.

    Examples
    --------
    >>> from pathlib import Path
    >>> from mgeo.studies import read_study
    >>> text = '''
    ... title = "Two algorithms"
    ... evaluations = 200
    ... seeds = [1, 2]
    ... problems = [{name = "pymoo:zdt1"}]
    ... algorithms = [{name = "mgeo-directed"}, {name = "nsga2"}]
    ... '''
    >>> _ = Path("study.toml").write_text(text)
    >>> read_study("study.toml").title
    'Two algorithms'
    """
    path = Path(path)
    if not path.exists():
        raise FileNotFoundError(f"there is no study file {path}")
    text = read_text(path)
    with convert_file_errors(path):
        return parse_study(text, path.parent, allow_imports=allow_imports)


def parse_study(text: str, folder: Path, *, allow_imports: bool = True) -> Study:
    """Parse and validate the text of a study file; scenario files are relative to `folder`.

    Raises
    ------
    ValueError, TypeError
        If the content is invalid. The message contains the key, but not the file.
    """
    table = validate_table(StudyTable, tomllib.loads(text))
    configurations_by_key: dict[str, list[Any]] = {"problems": [], "algorithms": []}
    for i, problem in enumerate(table.problems):
        configurations_by_key["problems"] += _expand_problems(problem, i, folder, allow_imports)
    for i, algorithm in enumerate(table.algorithms):
        configurations_by_key["algorithms"] += _expand_algorithms(algorithm, i, allow_imports)
    for key, configurations in configurations_by_key.items():
        for label, times in Counter(each.label for each in configurations).items():
            if times > 1:
                raise ValueError(
                    f"{key}: {label!r} is there twice; set different labels by the key label"
                )
    labels = [each.label for each in configurations_by_key["algorithms"]]
    mentioned = [] if table.control is None else [("control", table.control)]
    mentioned += [("published.table", name) for name in getattr(table.published, "table", ())]
    for key, label in mentioned:
        if label not in labels:
            raise ValueError(
                f"{key}: {label!r} is no algorithm of this study: expected one of "
                f"{', '.join(sorted(labels))}"
            )
    tuples = {key: tuple(configurations) for key, configurations in configurations_by_key.items()}
    return Study(**{**dict(table), **tuples, "text": text})


def _expand_problems(
    table: ProblemTable, index: int, folder: Path, allow_imports: bool
) -> Iterator[ProblemConfiguration]:
    """Yield a configuration for each combination of name and scenario in a table."""
    where = f"problems[{index}]."
    if table.scenario is not None and table.options is not None:
        raise ValueError(f"{where}scenario and options: expected one of them")
    with _add_location_to_errors(where):
        full_names = [name for pattern in table.name for name in expand_name(pattern)]
    for full, scenario in product(full_names, table.scenario or ("",)):
        label, options = format_short_name(full), table.options or {}
        values = {**options, "name": label}
        if scenario:
            options = read_scenario(
                full, scenario, folder, trusted_classes=(full,) if allow_imports else ()
            )
            values["scenario"] = Path(scenario).stem
            label = f"{label} {values['scenario']}"
        if table.label is not None:
            label = _fill_label(table.label, where, values)
        parts = None if table.parts is None else tuple(table.parts)
        yield ProblemConfiguration(label, full, options, parts)


def _expand_algorithms(
    table: AlgorithmTable, index: int, allow_imports: bool
) -> Iterator[AlgorithmConfiguration]:
    """Yield a configuration for each combination of the listed parameter values in a table."""
    where = f"algorithms[{index}]."
    parameters = table.parameters
    varied_keys = [key for key, value in parameters.items() if isinstance(value, list)]
    lists = [value if isinstance(value, list) else [value] for value in parameters.values()]
    for name in table.name:
        with _add_location_to_errors(where):
            if allow_imports or ":" not in name:
                complete_parameters(name, parameters)
        for values in product(*lists):
            combination = dict(zip(parameters, values, strict=True))
            label = ", ".join([name, *(f"{key} = {combination[key]}" for key in varied_keys)])
            if table.label is not None:
                label = _fill_label(table.label, where, {"name": name, **combination})
            yield AlgorithmConfiguration(label, name, combination)


def _fill_label(text: str, location: str, values: Mapping[str, Any]) -> str:
    # str.format would evaluate attributes and widths, as in {name.__class__} or {name:>999999999}.
    parts = re.split(r"\{(.*?)\}", text)
    if set(parts[1::2]) - set(values):
        raise ValueError(
            f"{location}label = {text!r:.80}: expected in braces only {', '.join(values)}"
        )
    parts[1::2] = (str(values[name]) for name in parts[1::2])
    return "".join(parts)


@contextmanager
def _add_location_to_errors(location: str) -> Iterator[None]:
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{location}name: {error}") from error
