"""Schema of study files, from which the JSON Schema for editors is generated."""

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
    """Table of a study file that defines one or more problems."""

    name: Names = Field(
        description="Name of an installed problem, or of a benchmark problem: pymoo:NAME; "
        "shifted:NAME, a pymoo problem with its optimum moved off the bounds; or "
        "coco:SUITE/fN/dN/iN, where numbers may be ranges. MODULE:CLASS is a class of your own, "
        "from a module in the current folder or in an installed package. Each name in a list "
        "defines a problem."
    )
    label: str | None = Field(
        None,
        description="Label of the problem in tables and figures. {name}, {scenario} and any "
        "{option} in braces are replaced by their values.",
    )
    scenario: Names | None = Field(
        None,
        description="Scenario files, with paths relative to the study file, or names of presets.",
    )
    options: dict[str, Any] | None = Field(None, description="Options of the problem, by name.")
    parts: NonEmptyList[float] | None = Field(
        None,
        description="Ascending values of the first objective that divide the front into parts. "
        "The hypervolume of each part is reported. By default, each of three parts contains a "
        "third of the points of the reference front.",
    )


class AlgorithmTable(Table):
    """Table of a study file that defines an algorithm for each combination of parameter values.

    A parameter whose value is itself a list is written as a list in a list: momentum = [[0.6,
    0.4]].
    """

    model_config = ConfigDict(extra="allow")

    name: Names = Field(
        description=f"Name of the algorithm: one of {', '.join(ALGORITHMS)}; an algorithm of an "
        "installed plugin; or module:Class."
    )
    label: str | None = Field(
        None,
        description="Label of the algorithm in tables and figures. {name} and any {parameter} in "
        "braces are replaced by their values.",
    )

    @property
    def parameters(self) -> dict[str, Any]:
        """Parameters of the algorithm, that is, all keys except name and label."""
        return self.model_extra or {}


class PublishedTable(Table):
    """Table of a study file with published indicator values to compare with."""

    source: str = Field(description="Publication that the values are taken from.")
    evaluations: int | None = Field(
        None,
        ge=1,
        description="Number of evaluations of each published run. The published values are shown "
        "only beside results with this number of evaluations.",
    )
    table: dict[str, dict[str, float]] = Field(
        description="Published values, by the label of the algorithm and the table column."
    )


class StudySettings(Table):
    """Settings of a study, that is, all keys except problems and algorithms."""

    title: str = Field(description="Title of the report pages.")
    description: str = Field("", description="Introduction on the report pages.")
    evaluations: int = Field(ge=1, description="Number of evaluations of each run.")
    per_variable: bool = Field(
        False,
        description="Whether evaluations and grid are multiplied by the number of variables of "
        "each problem.",
    )
    seeds: Seeds = Field(description="Number n of seeds, for the seeds 1 to n, or a list of seeds.")
    grid: Grid = Field(
        DEFAULT_GRID_SIZE,
        description="Number of equal steps of a run after which its front is measured, or a list "
        "of evaluation counts.",
    )
    control: str | None = Field(
        None,
        description="Label of the control algorithm, which is compared with every other algorithm. "
        "On the screen, in reports and in `p_holm_control`, p values are corrected for these "
        "comparisons only. Choose the control before results are available.",
    )
    published: PublishedTable | None = Field(None, description="Published values.")


class StudyTable(StudySettings):
    """Content of a study file: settings, problems and algorithms."""

    problems: NonEmptyList[ProblemTable] = Field(description="Problems of the study.")
    algorithms: NonEmptyList[AlgorithmTable] = Field(description="Algorithms of the study.")


def build_study_schema() -> str:
    """Return the JSON Schema of study files as text."""
    version = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return json.dumps(version | StudyTable.model_json_schema(), indent=2)
