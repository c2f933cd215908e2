"""The JSON Schema of scenario files."""

from __future__ import annotations

from typing import Any

from mgeo_attitude.fields.checking import section_model
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.toml import PRESETS


def scenario_schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of what `Scenario.from_dict` takes, for editors.

    A file may leave out what its preset has, so only a file without one is told what is missing.
    What several keys say together, such as multiples of the step, is checked on reading only.

    Examples
    --------
    >>> from mgeo_attitude import scenario_schema
    >>> scenario_schema()["properties"]["step"]["description"]
    'time step of the filter [s]'
    """
    dialect = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    schema = section_model(Scenario, "preset", PRESETS).model_json_schema()
    for section in schema["$defs"].values():
        section.pop("required", None)
    alone = {"required": schema.pop("required")}
    return dialect | schema | {"anyOf": [{"required": ["preset"]}, alone]}
