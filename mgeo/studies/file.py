"""A study as a file: problems, algorithms, budget and seeds in commented TOML."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mgeo.algorithms.parameters import integer
from mgeo.plugins import built, load_problem
from mgeo.reading import entry, errors_of, parse_toml, read_text
from mgeo.runs.algorithms import build_algorithm, complete_parameters
from mgeo.runs.scenario import read_scenario
from mgeo.studies.execute import GRID_POINTS
from mgeo.studies.labels import distinct, filled

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem

PYMOO = "pymoo:"  # before the name of one of pymoo's test problems
_KEYS = ("title", "about", "evaluations", "seeds", "grid", "problems", "algorithms", "published")
_MOST = 100_000  # runs of a kind: more are a slip
_PROBLEM_KEYS = ("name", "label", "scenario", "options")


@dataclass(frozen=True)
class Case:
    """One problem of a study."""

    label: str
    name: str
    options: Mapping[str, Any] = field(default_factory=dict)

    def build(self) -> Problem:
        """The installed problem of this name, or pymoo's if it begins with ``pymoo:``.

        Raises
        ------
        ValueError, TypeError
            If there is none, or it refuses an option.
        """
        if not self.name.startswith(PYMOO):
            return load_problem(self.name, self.options)
        from pymoo.problems import get_problem

        name = self.name.removeprefix(PYMOO)
        try:
            return built(self.name, lambda: get_problem(name, **self.options))
        except Exception as error:  # pymoo raises bare ones for names it does not know
            given = dict(self.options)
            raise ValueError(f"pymoo has no problem {name!r} with {given}: {error}") from error


@dataclass(frozen=True)
class Contender:
    """One algorithm of a study, with all its parameters."""

    label: str
    name: str
    parameters: Mapping[str, Any]

    def build(self, problem: Problem) -> Algorithm:
        """The algorithm, for this problem.

        Raises
        ------
        ValueError, TypeError
            If it refuses a parameter or the problem.
        """
        return build_algorithm(self.name, self.parameters, problem)


@dataclass(frozen=True)
class Published:
    """Values of a publication to be shown beside the study's: by label, then by column."""

    source: str
    table: Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class Study:
    """What a study file says; `text` is the file."""

    title: str
    about: str
    evaluations: int
    seeds: tuple[int, ...]
    grid: int
    cases: tuple[Case, ...]
    contenders: tuple[Contender, ...]
    published: Published | None
    text: str

    def reduced(self, evaluations: int | None = None, seeds: int | None = None) -> Study:
        """The same study with another budget, or with its first so many seeds.

        Raises
        ------
        ValueError, TypeError
            If a number is out of range.
        """
        changes: dict[str, Any] = {}
        if evaluations is not None:
            changes["evaluations"] = integer("evaluations", evaluations, low=1)
        if seeds is not None:
            count = integer("seeds", seeds, low=1, high=_MOST)
            more = range(max(self.seeds) + 1, max(self.seeds) + 1 + count)
            changes["seeds"] = (*self.seeds, *more)[:count]
        return replace(self, **changes)


def read_study(path: Path | str) -> Study:
    """A study from its file.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError, TypeError
        If it is no valid study; the message names the file and the key.
    """
    path = Path(path)
    if not path.exists():
        raise FileNotFoundError(f"there is no study file {path}")
    text = read_text(path)
    with errors_of(path):
        return parse_study(text, path.parent)


def parse_study(text: str, folder: Path) -> Study:
    """A study from the text of its file; scenario files are relative to `folder`.

    Raises
    ------
    ValueError, TypeError
        As `read_study`, without the name of the file.
    """
    data = parse_toml(text)
    _refuse_unknown(data, _KEYS, "")
    for key in ("title", "evaluations", "seeds", "problems", "algorithms"):
        if key not in data:
            raise ValueError(f"{key} is missing")
    cases = _cases(_tables(data, "problems"), folder)
    contenders = [c for i, t in enumerate(_tables(data, "algorithms")) for c in _contenders(t, i)]
    for key, labels in (
        ("problems", [case.label for case in cases]),
        ("algorithms", [contender.label for contender in contenders]),
    ):
        twice = sorted({label for label in labels if labels.count(label) > 1})
        if twice:
            raise ValueError(f"{key}: {twice[0]!r} is there twice; expected different labels")
    study = Study(
        title=_string(data, "title"),
        about=_string(data, "about") if "about" in data else "",
        evaluations=integer("evaluations", data["evaluations"], low=1),
        seeds=_seeds(data["seeds"]),
        grid=integer("grid", data.get("grid", GRID_POINTS), low=1, high=_MOST),
        cases=tuple(cases),
        contenders=tuple(contenders),
        published=_published(data["published"]) if "published" in data else None,
        text=text,
    )
    _check_published(study)
    return study


def _cases(tables: Sequence[Mapping[str, Any]], folder: Path) -> list[Case]:
    """Their problems, with longer labels where shorter ones would be the same."""
    found = [each for i, table in enumerate(tables) for each in _named(table, i, folder)]
    labels = distinct([candidates for _, candidates in found])
    return [replace(case, label=label) for (case, _), label in zip(found, labels, strict=True)]


def _named(
    table: Mapping[str, Any], index: int, folder: Path
) -> Iterator[tuple[Case, Sequence[str]]]:
    """Every problem of a table, and what it may be called, the shortest first."""
    where = f"problems[{index}]."
    _refuse_unknown(table, _PROBLEM_KEYS, where)
    if "name" not in table:
        raise ValueError(f"{where}name is missing")
    if "scenario" in table and "options" in table:
        raise ValueError(f"{where}scenario and options: expected one of them")
    options = entry(table, "options", dict, where) if "options" in table else {}
    for full in _listed(table["name"]):
        if not isinstance(full, str):
            raise TypeError(f"{where}name = {full!r}: expected a string, or a list of strings")
        name = full.removeprefix(PYMOO)
        if "scenario" not in table:
            details = [f"{key} = {value}" for key, value in options.items()]
            names = (name, ", ".join([name, *details]), ", ".join([full, *details]))
            yield Case("", full, options), _given(table, where, {**options, "name": name}) or names
            continue
        for scenario in _listed(table["scenario"]):
            if not isinstance(scenario, str):
                raise TypeError(f"{where}scenario = {scenario!r:.80}: expected a string")
            stem = Path(scenario).stem
            names = (f"{name} {stem}", f"{name} {scenario}", f"{full} {scenario}")
            given = _given(table, where, {"name": name, "scenario": stem})
            yield Case("", full, read_scenario(scenario, folder)), given or names


def _given(table: Mapping[str, Any], where: str, values: Mapping[str, Any]) -> tuple[str, ...]:
    return (filled(table, where, values),) if "label" in table else ()


def _contenders(table: Mapping[str, Any], index: int) -> Iterator[Contender]:
    """Every combination of the values in lists; a list as one value is a list in a list."""
    where = f"algorithms[{index}]."
    if "name" not in table:
        raise ValueError(f"{where}name is missing")
    given = {key: value for key, value in table.items() if key not in ("name", "label")}
    count = math.prod(len(_listed(value)) for value in given.values())
    if count > _MOST:
        raise ValueError(f"{where[:-1]} stands for {count} algorithms: expected at most {_MOST}")
    for name in _listed(table["name"]):
        if not isinstance(name, str):
            raise TypeError(f"{where}name = {name!r:.80}: expected a string, or a list of strings")
        try:
            complete_parameters(name, given)
        except ValueError as error:
            raise ValueError(f"{where}name: {error}") from error
        for values in product(*map(_listed, given.values())):
            chosen = dict(zip(given, values, strict=True))
            yield Contender(_label(table, where, name, chosen, given), name, chosen)


def _label(
    table: Mapping[str, Any],
    where: str,
    name: str,
    chosen: Mapping[str, Any],
    given: Mapping[str, Any],
) -> str:
    if "label" in table:
        return filled(table, where, {"name": name, **chosen})
    swept = [f"{key} = {chosen[key]}" for key in given if isinstance(given[key], list)]
    return ", ".join([name, *swept])


def _published(table: Any) -> Published:
    if not isinstance(table, dict) or set(table) != {"source", "table"}:
        raise ValueError("published: expected the keys source and table")
    rows = entry(table, "table", dict[str, dict[str, float]], "published.")
    return Published(_string(table, "source"), rows)


def _check_published(study: Study) -> None:
    labels = {contender.label for contender in study.contenders}
    for label in study.published.table if study.published else ():
        if label not in labels:
            raise ValueError(
                f"published.table: {label!r} is no algorithm of this study, which are "
                f"{', '.join(sorted(labels))}"
            )


def _seeds(value: Any) -> tuple[int, ...]:
    if not isinstance(value, list):
        return tuple(range(1, integer("seeds", value, low=1, high=_MOST) + 1))
    seeds = tuple(integer(f"seeds[{i}]", seed, low=0) for i, seed in enumerate(value))
    if not seeds or len(set(seeds)) < len(seeds):
        raise ValueError(f"seeds = {value}: expected one or more different ones")
    return seeds


def _tables(data: Mapping[str, Any], key: str) -> list[Mapping[str, Any]]:
    value = data[key]
    if not (isinstance(value, list) and value and all(isinstance(v, dict) for v in value)):
        raise TypeError(f"{key}: expected one table [[{key}]] or more")
    return value


def _listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def _string(data: Mapping[str, Any], key: str) -> str:
    if not isinstance(data[key], str):
        raise TypeError(f"{key} = {data[key]!r}: expected a string")
    return str(data[key])


def _refuse_unknown(table: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in known:
            raise ValueError(f"{where}{key} is unknown: expected {', '.join(known)}")
