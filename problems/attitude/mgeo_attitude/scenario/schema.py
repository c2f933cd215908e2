"""JSON Schema of scenario files, for editors."""

from __future__ import annotations

from typing import Any

from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.toml import PRESETS
from mgeo_attitude.settings.base import build_schema


def build_scenario_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of scenario files, as a dict.

    Editors use the schema to complete and validate scenario files. Keys without a default are
    required only in a file without a preset. The schema does not express conditions on several
    keys, such as multiples of the step, which `Scenario` checks.

    Examples
    --------
    >>> from mgeo_attitude import build_scenario_schema
    >>> step = build_scenario_schema()["properties"]["step"]
    >>> step["description"], step["unit"]
    ('time step of the filter', 's')
    """
    schema = build_schema(Scenario)
    description = "complete scenario, whose values apply to all keys that the file does not state"
    preset = {"preset": {"enum": list(PRESETS), "description": description}}
    tables = {
        name: {key: value for key, value in table.items() if key != "required"}
        for name, table in schema["$defs"].items()
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **{key: value for key, value in schema.items() if key != "required"},
        "properties": preset | schema["properties"],
        "$defs": tables,
        "anyOf": [{"required": ["preset"]}, {"required": schema["required"]}],
    }
