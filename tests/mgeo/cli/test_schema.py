"""The JSON Schema that editors check study files by."""

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

from ..studies.test_file import SMALL, STUDIES

FILES = sorted(STUDIES.glob("*.toml"))[:2]


@pytest.fixture
def schema(mgeo):
    done = mgeo("schema", "study")
    assert (done.exit_code, done.stderr) == (0, "")
    return json.loads(done.stdout)


def test_the_schema_in_the_documentation_is_the_one_that_is_printed(schema):
    assert json.loads((STUDIES / "study.schema.json").read_text()) == schema


@pytest.mark.parametrize("path", FILES, ids=[path.stem for path in FILES])
def test_the_published_studies_keep_it_and_name_it(path, schema):
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
def test_it_refuses_what_the_program_refuses(old, new, schema):
    jsonschema.validate(tomllib.loads(SMALL), schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(tomllib.loads(SMALL.replace(old, new)), schema)
