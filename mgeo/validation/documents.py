"""JSON Schemas of the documents that commands print with ``--json``, and of JSON files.

A document is declared by classes: a TypedDict with a docstring below each key, or a class that the
document is made from, with its attributes described in the numpydoc section ``Attributes``.
"""

from __future__ import annotations

import ast
import inspect
import re
import sys
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any

from pydantic import ConfigDict, TypeAdapter, with_config
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from mgeo.plugins.discovery import COMMANDS, list_plugins
from mgeo.validation.field_docstrings import parse_field_docstrings

#: Decorator of a TypedDict whose objects have further keys, which depend on the problem.
extensible = with_config(ConfigDict(extra="allow"))

#: Units by the ending of a key, longer endings first.
UNITS = {
    "_deg_h": "deg/h",
    "_deg_s": "deg/s",
    "_deg": "deg",
    "_arcmin": "arcmin",
    "_nt": "nT",
    "_percent": "%",
    "_s": "s",
    "_keur": "1000 EUR",
    "_mw": "mW",
    "_g": "g",
    "bytes": "byte",
}


@dataclass(frozen=True)
class Document:
    """Declaration of a JSON document that a command prints or a file contains.

    Attributes
    ----------
    source : str
        Commands that print the document, or the file that contains it.
    parts : tuple of types
        Classes that declare the keys. The document has the keys of all of them.
    """

    source: str
    parts: tuple[type, ...]

    def build_schema(self) -> dict[str, Any]:
        """Build the JSON Schema of the document, with descriptions and units of the keys."""
        schemas = [
            TypeAdapter(part).json_schema(mode="serialization", schema_generator=_Generator)
            for part in self.parts
        ]
        properties: dict[str, Any] = {}
        definitions: dict[str, Any] = {}
        for schema in schemas:
            properties |= schema["properties"]
            definitions |= schema.get("$defs", {})
        return {
            "$schema": GenerateJsonSchema.schema_dialect,
            "title": self.source,
            "type": "object",
            "properties": properties,
            "required": [key for schema in schemas for key in schema.get("required", ())],
            "additionalProperties": any(schema["additionalProperties"] for schema in schemas),
            **({"$defs": definitions} if definitions else {}),
        }


def collect_documents() -> dict[str, Document]:
    """Return a dict of all JSON documents that `mgeo` and its plugins declare.

    A plugin declares its documents as a dict ``DOCUMENTS`` in the module ``documents`` of its
    package.
    """
    packages = [plugin.entry_point.module.partition(".")[0] for plugin in list_plugins(COMMANDS)]
    documents: dict[str, Document] = {}
    for package in dict.fromkeys(["mgeo", *packages]):
        with suppress(ModuleNotFoundError):
            documents |= import_module(f"{package}.documents").DOCUMENTS
    return documents


class _Generator(GenerateJsonSchema):
    """Generator of JSON Schemas that adds units and descriptions."""

    def typed_dict_schema(self, schema: core_schema.TypedDictSchema) -> JsonSchemaValue:
        return _complete(super().typed_dict_schema(schema), schema["cls"])

    def dataclass_schema(self, schema: core_schema.DataclassSchema) -> JsonSchemaValue:
        return _complete(super().dataclass_schema(schema), schema["cls"])

    def model_schema(self, schema: core_schema.ModelSchema) -> JsonSchemaValue:
        return _complete(super().model_schema(schema), schema["cls"])


def _complete(schema: JsonSchemaValue, cls: type) -> JsonSchemaValue:
    """Add descriptions and units to the schema of a class, and forbid unknown keys by default."""
    texts = _describe_attributes(cls) | _read_field_docstrings(cls)
    for key, entry in schema.get("properties", {}).items():
        entry.pop("title", None)
        entry["description"] = " ".join((entry.get("description") or texts.get(key, "")).split())
        unit = next((unit for ending, unit in UNITS.items() if key.endswith(ending)), None)
        if unit is not None:
            entry["unit"] = unit
    text = re.split(r"\n\n\w+\n---", inspect.cleandoc(cls.__doc__ or ""))[0].replace("``", "`")
    return {"additionalProperties": False} | schema | {"description": " ".join(text.split())}


def _describe_attributes(cls: type) -> dict[str, str]:
    """Read the descriptions of attributes from the docstring of a class."""
    section = inspect.cleandoc(cls.__doc__ or "").partition("Attributes\n----------\n")[2]
    entries = re.findall(r"^(\w[\w, ]*) : .*\n((?: +.*(?:\n|$))+)", section, re.MULTILINE)
    return {
        name: re.sub(r"\bNone\b", "null", " ".join(text.split()))
        for names, text in entries
        for name in names.split(", ")
    }


def _read_field_docstrings(cls: type) -> dict[str, str]:
    """Read the docstrings below the keys of a TypedDict, including inherited keys."""
    texts: dict[str, str] = {}
    for base in getattr(cls, "__orig_bases__", ()):
        texts |= _read_field_docstrings(base) if isinstance(base, type) else {}
    return texts | _parse_module(cls.__module__).get(cls.__name__, {})


@cache
def _parse_module(name: str) -> dict[str, dict[str, str]]:
    """Return the field docstrings of all classes in a module, as nested dicts."""
    tree = ast.parse(inspect.getsource(sys.modules[name]))
    return {
        definition.name: parse_field_docstrings(definition)
        for definition in tree.body
        if isinstance(definition, ast.ClassDef)
    }
