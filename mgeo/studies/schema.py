"""Schema of study files; editors use it as a JSON Schema."""

from __future__ import annotations

import json
from typing import Annotated, Any, TypeVar

from pydantic import BeforeValidator, ConfigDict, Field, PlainValidator

from mgeo.runs.registry import ALGORITHMS
from mgeo.studies.arguments import DEFAULT_GRID_SIZE, expand_seeds
from mgeo.validation.arguments import validate_integer
from mgeo.validation.tables import Table


def _convert_to_list(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


def _validate_grid(value: Any) -> int | tuple[int, ...]:
    if isinstance(value, list | tuple) and value:
        return tuple(validate_integer(f"grid[{i}]", step, low=1) for i, step in enumerate(value))
    return validate_integer("grid", value, low=1)


T = TypeVar("T")
NonEmptyList = Annotated[list[T], Field(min_length=1)]
PositiveInteger = Annotated[int, Field(ge=1)]
Seed = Annotated[int, Field(ge=0)]
Names = Annotated[NonEmptyList[str], BeforeValidator(_convert_to_list, str | NonEmptyList[str])]
Grid = Annotated[
    int | tuple[int, ...],
    PlainValidator(_validate_grid, PositiveInteger | NonEmptyList[PositiveInteger]),
]
Seeds = Annotated[
    tuple[int, ...], PlainValidator(expand_seeds, PositiveInteger | NonEmptyList[Seed])
]


class ProblemTable(Table):
    """One problem, or several problems that differ in name or scenario."""

    name: Names = Field(
        description="Installed problem, or problem of a collection: pymoo:NAME; shifted:NAME, a "
        "pymoo problem with its optimum moved off the bounds; or coco:SUITE/fN/dN/iN, where "
        "numbers may be ranges."
    )
    label: str | None = Field(
        None, description="Label; {name}, {scenario} and {option} are replaced by their values."
    )
    scenario: Names | None = Field(
        None, description="Scenario files, relative to this file, or presets."
    )
    options: dict[str, Any] | None = Field(None, description="Options of the problem.")
    parts: NonEmptyList[float] | None = Field(
        None,
        description="Ascending values of the first objective that divide the front into parts, for "
        "the hypervolume of each part. By default, each part has a third of the points of the "
        "reference front.",
    )


class AlgorithmTable(Table):
    """One algorithm with its parameters, or one algorithm per combination of listed values.

    A parameter whose value is a list is written as a list in a list: momentum = [[0.6, 0.4]].
    """

    model_config = ConfigDict(extra="allow")

    name: Names = Field(
        description=f"One of {', '.join(ALGORITHMS)}; an algorithm of an installed plugin; or "
        "module:Class."
    )
    label: str | None = Field(
        None, description="Label; {name} and {parameter} are replaced by their values."
    )

    @property
    def parameters(self) -> dict[str, Any]:
        """Parameters of the algorithm: all keys except name and label."""
        return self.model_extra or {}


class PublishedTable(Table):
    """Published values for comparison with the results of the study."""

    source: str
    evaluations: int | None = Field(
        None,
        ge=1,
        description="Evaluations of each published run. The values are listed only beside runs "
        "with this number of evaluations.",
    )
    table: dict[str, dict[str, float]] = Field(
        description="Values by algorithm label, then by column."
    )


class StudySettings(Table):
    """Keys of a study except its problems and algorithms."""

    title: str
    description: str = ""
    evaluations: int = Field(ge=1, description="Evaluations of each run.")
    per_variable: bool = Field(
        False,
        description="Whether evaluations and grid are multiplied by the number of variables of the "
        "problem.",
    )
    seeds: Seeds = Field(description="Number of seeds (1, 2, ...), or a list of seeds.")
    grid: Grid = Field(
        DEFAULT_GRID_SIZE,
        description="Number of equal steps, or a list of evaluation counts, at which fronts are "
        "measured.",
    )
    control: str | None = Field(
        None,
        description="Label of the control algorithm, which is compared with each other algorithm. "
        "The p values are corrected for these comparisons only, so choose the control before "
        "results are available.",
    )
    published: PublishedTable | None = None


class StudyTable(StudySettings):
    """A comparison of algorithms on problems."""

    problems: NonEmptyList[ProblemTable]
    algorithms: NonEmptyList[AlgorithmTable]


def build_study_schema() -> str:
    """Return the JSON Schema of study files as text."""
    version = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return json.dumps(version | StudyTable.model_json_schema(), indent=2)
