"""JSON Schema of study files, with which editors validate them."""

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

from ..studies.test_file import SMALL, STUDIES

FILES = sorted(STUDIES.glob("*.toml"))[:2]


@pytest.fixture
def schema(mgeo):
    done = mgeo("schema", "study.toml")
    assert (done.exit_code, done.stderr) == (0, "")
    return json.loads(done.stdout)


def test_schema_in_the_documentation_equals_the_printed_one(schema):
    assert json.loads((STUDIES / "study.schema.json").read_text()) == schema


@pytest.mark.parametrize("path", FILES, ids=[path.stem for path in FILES])
def test_published_studies_name_the_schema_and_satisfy_it(path, schema):
    text = path.read_text()
    head, name = text.splitlines()[0].split()
    assert (head, Path(path.parent, name).is_file()) == ("#:schema", True)
    jsonschema.validate(tomllib.loads(text), schema)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('title = "small"', ""),
        ("evaluations = 100", "evaluations = 0"),
        ("seeds = 2", "seeds = 2\nbudget = 3"),
        ('name = "pymoo:zdt1"', "name = 3"),
    ],
)
def test_schema_refuses_invalid_study_files(old, new, schema):
    jsonschema.validate(tomllib.loads(SMALL), schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(tomllib.loads(SMALL.replace(old, new)), schema)
