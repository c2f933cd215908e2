"""Study files: problems, algorithms, budget and seeds of a study in TOML."""

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
    """Problem of a study: label, name, options and bounds of the parts of its front."""

    label: str
    name: str
    options: dict[str, Any]
    parts: tuple[float, ...] | None = None

    def build(self) -> Problem:
        """Build the problem from a plugin or from a collection of test problems.

        Raises
        ------
        ValueError, TypeError
            If there is no problem of this name, or an option is invalid.
        """
        return load_problem(self.name, self.options, trusted_classes=(self.name,))


@dataclass(frozen=True)
class AlgorithmConfiguration:
    """Label, name and parameters of an algorithm in a study."""

    label: str
    name: str
    parameters: dict[str, Any]

    def build(self, problem: Problem) -> Algorithm:
        """Build the pymoo algorithm for a problem, without setting it up.

        Raises
        ------
        ValueError, TypeError
            If a parameter is invalid, or the algorithm does not support the problem. The message
            begins with the label of the algorithm.
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
    title, description : str
        Title and introduction of the report page.
    evaluations : int
        Number of evaluations of each run.
    per_variable : bool
        Whether `evaluations` and `grid` are multiplied by the number of variables of the problem.
    seeds : tuple of int
        Seeds of the runs. Each algorithm runs with each seed on each problem.
    grid : int or tuple of int
        Number of equal steps, or the evaluation counts, at which fronts are measured.
    control : str or None
        Label of the control algorithm, which is compared with every other algorithm.
    problems, algorithms : tuple of ProblemConfiguration and of AlgorithmConfiguration
        Problems and algorithms of the study.
    published : PublishedTable or None
        Published values to show beside the results.
    text : str
        Text of the file.

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
    >>> study.seeds, [algorithm.label for algorithm in study.algorithms]
    ((1, 2), ['mgeo-directed', 'nsga2'])
    """

    problems: tuple[ProblemConfiguration, ...]
    algorithms: tuple[AlgorithmConfiguration, ...]
    text: str

    def build_plan(self) -> dict[str, Any]:
        """Return the problems, algorithms, budget and seeds as a JSON-serializable dict.

        The plan identifies the study when it is resumed. Dates in options are text in ISO 8601.

        Returns
        -------
        dict
            ``problems`` and ``algorithms`` by label, ``evaluations``, ``per_variable`` and
            ``seeds``.

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
        """Return the number of evaluations of a run, and the counts at which to measure its front.

        Returns
        -------
        n_eval : int
            Number of evaluations of a run.
        grid : int or list of int
            Number of equal steps, or the evaluation counts, at which fronts are measured.
        """
        factor = problem.n_var if self.per_variable else 1
        if isinstance(self.grid, int):
            return self.evaluations * factor, self.grid
        steps = [step * factor for step in self.grid if step <= self.evaluations]
        return self.evaluations * factor, steps

    @property
    def n_runs(self) -> int:
        """Number of runs, one for each problem, algorithm and seed."""
        return len(self.problems) * len(self.algorithms) * len(self.seeds)

    def format_size(self) -> str:
        """Return the number of problems, algorithms, seeds, runs and evaluations as text."""
        counts = {
            "problem": len(self.problems),
            "algorithm": len(self.algorithms),
            "seed": len(self.seeds),
        }
        sizes = ", ".join(f"{n:,} {noun}{'' if n == 1 else 's'}" for noun, n in counts.items())
        unit = " per variable" if self.per_variable else ""
        return f"{sizes}: {self.n_runs:,} runs of {self.evaluations:,} evaluations{unit}"

    def with_budget(self, evaluations: int | None = None, seeds: int | None = None) -> Study:
        """Return a copy of the study with a different number of evaluations or seeds.

        Parameters
        ----------
        evaluations : int, optional
            Number of evaluations of each run; None leaves it unchanged.
        seeds : int, optional
            Number of seeds; None leaves the seeds unchanged. Seeds are taken from the start of the
            list, and new ones are appended if the list is shorter.

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
            new_seeds = range(max(self.seeds) + 1, max(self.seeds) + 1 + count)
            changes["seeds"] = (*self.seeds, *new_seeds)[:count]
        return self.model_copy(update=changes)


def read_study(path: Path | str, *, allow_imports: bool = True) -> Study:
    """Read and validate a study file.

    Parameters
    ----------
    path : path
        TOML file.
    allow_imports : bool
        Whether modules of algorithms and problems ``module:Class`` may be imported to validate
        their parameters.

    Returns
    -------
    Study
        Content of the file.

    Raises
    ------
    FileNotFoundError
        If there is no file at `path`.
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
    """Parse and validate the TOML text of a study file.

    Parameters
    ----------
    text : str
        Text of the file.
    folder : Path
        Folder of the file, to which the paths of scenario files are relative.
    allow_imports : bool
        Whether modules of algorithms and problems ``module:Class`` may be imported.

    Returns
    -------
    Study
        Content of the file.

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
        for label, count in Counter(c.label for c in configurations).items():
            if count > 1:
                raise ValueError(
                    f"{key}: the label {label!r} occurs twice; set different labels with the key "
                    "label"
                )
    labels = [algorithm.label for algorithm in configurations_by_key["algorithms"]]
    references = [] if table.control is None else [("control", table.control)]
    references += [("published.table", name) for name in getattr(table.published, "table", ())]
    for key, label in references:
        if label not in labels:
            raise ValueError(
                f"{key}: {label!r} is not an algorithm of this study: expected one of "
                f"{', '.join(sorted(labels))}"
            )
    tuples = {key: tuple(configurations) for key, configurations in configurations_by_key.items()}
    return Study(**{**dict(table), **tuples, "text": text})


def _expand_problems(
    table: ProblemTable, index: int, folder: Path, allow_imports: bool
) -> Iterator[ProblemConfiguration]:
    """Yield a problem for each combination of name and scenario in a table."""
    location = f"problems[{index}]."
    if table.scenario is not None and table.options is not None:
        raise ValueError(f"{location}scenario and options: expected only one of them")
    with _add_location_to_errors(f"{location}name"):
        full_names = [name for pattern in table.name for name in expand_name(pattern)]
    for full_name, scenario in product(full_names, table.scenario or ("",)):
        label, options = format_short_name(full_name), table.options or {}
        values = {**options, "name": label}
        if scenario:
            options = read_scenario(
                full_name, scenario, folder, trusted_classes=(full_name,) if allow_imports else ()
            )
            values["scenario"] = Path(scenario).stem
            label = f"{label} {values['scenario']}"
        if table.label is not None:
            label = _fill_label(table.label, location, values)
        parts = None if table.parts is None else tuple(table.parts)
        yield ProblemConfiguration(label, full_name, options, parts)


def _expand_algorithms(
    table: AlgorithmTable, index: int, allow_imports: bool
) -> Iterator[AlgorithmConfiguration]:
    """Yield an algorithm for each combination of name and parameter values in a table."""
    location = f"algorithms[{index}]"
    parameters = table.parameters
    varied_keys = [key for key, value in parameters.items() if isinstance(value, list)]
    lists = [value if isinstance(value, list) else [value] for value in parameters.values()]
    for name in table.name:
        with _add_location_to_errors(location):
            if allow_imports or ":" not in name:
                complete_parameters(name, parameters)
        for values in product(*lists):
            combination = dict(zip(parameters, values, strict=True))
            label = ", ".join([name, *(f"{key} = {combination[key]}" for key in varied_keys)])
            if table.label is not None:
                label = _fill_label(table.label, f"{location}.", {"name": name, **combination})
            yield AlgorithmConfiguration(label, name, combination)


def _fill_label(text: str, location: str, values: Mapping[str, Any]) -> str:
    # str.format would evaluate attributes and widths, as in {name.__class__} or {name:>999999999}.
    parts = re.split(r"\{(.*?)\}", text)
    if set(parts[1::2]) - set(values):
        raise ValueError(
            f"{location}label = {text!r:.80}: expected only {', '.join(values)} in braces"
        )
    parts[1::2] = (str(values[name]) for name in parts[1::2])
    return "".join(parts)


@contextmanager
def _add_location_to_errors(location: str) -> Iterator[None]:
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{location}: {error}") from error
