"""The JSON Schema of scenario files."""

from __future__ import annotations

from typing import Any

from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.toml import PRESETS
from mgeo_attitude.settings.base import schema_of


def scenario_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of what `Scenario.from_dict` takes, for editors.

    A file may leave out what its preset has, so only a file without a preset must have every key
    that has no default. Conditions on several keys, such as multiples of the step, are checked by
    `Scenario` only.

    Examples
    --------
    >>> from mgeo_attitude import scenario_schema
    >>> step = scenario_schema()["properties"]["step"]
    >>> step["description"], step["unit"]
    ('time step of the filter', 's')
    """
    schema = schema_of(Scenario)
    preset = {"preset": {"enum": list(PRESETS)}}
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
