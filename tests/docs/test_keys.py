"""The pages of every key are made of the schemas, and name all of them."""

import json
import re
import sys
from pathlib import Path

import pytest

EXTENSIONS = Path(__file__).parents[2] / "docs" / "_extensions"


@pytest.fixture
def keys(monkeypatch):
    monkeypatch.syspath_prepend(EXTENSIONS)
    import keys

    yield keys
    sys.modules.pop("keys")


@pytest.mark.parametrize("kind", ["scenario", "study"])
def test_every_key_is_there_with_what_it_says(keys, kind):
    schema = keys.SCHEMAS[kind]()
    text = keys.markdown(schema)
    rows = re.findall(r"^\| `(\w+)` \| (.*) \| (.*) \| (.*) \|$", text, re.MULTILINE)
    tables = [schema, *(schema["$defs"][name] for name in keys._places(schema))]
    named = [key for table in tables for key in table.get("properties", {})]
    assert [row[0] for row in rows] == named
    assert len(tables) == 1 + len(schema["$defs"])  # each is found under some key
    assert all(takes for _, takes, _, _ in rows)
    for table in tables:
        for value in table.get("properties", {}).values():
            assert value.get("description", "").replace("|", "\\|") in text


def test_ranges_and_defaults_are_those_that_are_checked(keys):
    text = keys.markdown(keys.SCHEMAS["scenario"]())
    assert "| `step` | a number > 0 [s] | `1.0` | time step of the filter |" in text
    assert "| `eccentricity` | a number >= 0 and < 1 |" in text
    assert "## `[[sensors]]`, sun sensor" in text
    study = keys.markdown(keys.SCHEMAS["study"]())
    assert "| `evaluations` | an integer >= 1 | needed | of each run |" in study


def test_words(keys):
    assert keys._words("TLEOrbit") == "TLE orbit"
    assert keys._words("ManeuverLimits") == "maneuver limits"
    assert keys._default({"default": json.loads("null")}) == "none"
