"""What a study file may say; editors read it as a JSON Schema."""

from __future__ import annotations

import json
from typing import Annotated, Any, TypeVar

from pydantic import BeforeValidator, ConfigDict, Field, PlainValidator

from mgeo.runs.registry import ALGORITHMS
from mgeo.studies.arguments import GRID_POINTS, seed_numbers
from mgeo.validation.arguments import validate_integer
from mgeo.validation.tables import Table


def _listed(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


def _steps(value: Any) -> int | tuple[int, ...]:
    if isinstance(value, list | tuple) and value:
        return tuple(validate_integer(f"grid[{i}]", step, low=1) for i, step in enumerate(value))
    return validate_integer("grid", value, low=1)


T = TypeVar("T")
Some = Annotated[list[T], Field(min_length=1)]
Count = Annotated[int, Field(ge=1)]
Seed = Annotated[int, Field(ge=0)]
Names = Annotated[Some[str], BeforeValidator(_listed, str | Some[str])]
Grid = Annotated[int | tuple[int, ...], PlainValidator(_steps, Count | Some[Count])]
Seeds = Annotated[tuple[int, ...], PlainValidator(seed_numbers, Count | Some[Seed])]


class ProblemTable(Table):
    """One problem, or several that differ in name or scenario."""

    name: Names = Field(
        description="of an installed problem, or of a collection: pymoo:NAME, shifted:NAME for one "
        "of pymoo's with its optimum off the bounds, or COCO's coco:SUITE/fN/dN/iN with ranges"
    )
    label: str | None = Field(None, description="braces hold name, an option, or scenario")
    scenario: Names | None = Field(None, description="files relative to this one, or presets")
    options: dict[str, Any] | None = Field(None, description="options of the problem")
    parts: Some[float] | None = Field(
        None,
        description="values of the first objective, ascending, at which the front is parted for "
        "the hypervolume by parts; without them by thirds of the reference front",
    )


class AlgorithmTable(Table):
    """One algorithm and its parameters; a list of values stands for an algorithm with each.

    So a parameter that is a pair is a list in a list: momentum = [[0.6, 0.4]].
    """

    model_config = ConfigDict(extra="allow")

    name: Names = Field(
        description=f"one of {', '.join(ALGORITHMS)}; or of an installed plugin, or module:Class"
    )
    label: str | None = Field(None, description="braces hold name, or a parameter")

    @property
    def parameters(self) -> dict[str, Any]:
        """All but name and label."""
        return self.model_extra or {}


class PublishedTable(Table):
    """Values of a publication, to be compared with the study's."""

    source: str
    evaluations: int | None = Field(
        None, ge=1, description="of the published runs; of another budget they are not compared"
    )
    table: dict[str, dict[str, float]] = Field(description="by label, then by column")


class StudyKeys(Table):
    """Keys of a study but for its problems and algorithms."""

    title: str
    about: str = ""
    evaluations: int = Field(ge=1, description="of each run")
    per_variable: bool = Field(
        False, description="evaluations and grid are for each variable of a problem"
    )
    seeds: Seeds = Field(description="how many (1, 2, ...), or a list")
    grid: Grid = Field(
        GRID_POINTS, description="numbers of evaluations at which to measure: how many, or a list"
    )
    control: str | None = Field(
        None,
        description="label of an algorithm that is compared with every other one, on each problem "
        "and over all; p values of that are corrected for its rivals alone, so it is named before "
        "results are seen",
    )
    published: PublishedTable | None = None


class StudyTable(StudyKeys):
    """A comparison of algorithms on problems."""

    problems: Some[ProblemTable]
    algorithms: Some[AlgorithmTable]


def study_schema() -> str:
    """The JSON Schema of a study file, as text."""
    version = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return json.dumps(version | StudyTable.model_json_schema(), indent=2)
