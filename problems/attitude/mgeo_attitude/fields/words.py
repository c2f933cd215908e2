"""What pydantic refuses, in the words of a field: key, value, and what was expected."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, get_args

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from .errors import InvalidType, InvalidValue, KeyProblem, known_names
from .quantity import Quantity

Fields = Mapping[str, tuple[Any, Quantity]]


@contextmanager
def in_words(
    values: Mapping[str, Any], fields: Fields, known: Iterable[str] = (), table: bool = False
) -> Iterator[None]:
    """Turn the first error of validating `values`, of a file's `table` or not, into one of ours.

    An unknown key comes first, with a suggestion from the `known` ones.
    """
    try:
        yield
    except ValidationError as error:
        first = min(error.errors(include_url=False), key=lambda one: one["loc"][0] in fields)
        key = str(first["loc"][0])
        if key not in fields:
            expected = f"unknown key{known_names(key, known)}"
            raise KeyProblem(key, first["input"], expected) from None
        raise _problem(first, values.get(key), *fields[key], table) from None


def _problem(
    error: ErrorDetails, value: Any, annotation: Any, spec: Quantity, table: bool
) -> InvalidValue:
    kind, key = error["type"], str(error["loc"][0])
    places = list(error["loc"][1:])
    if kind == "missing" and not places:
        return KeyProblem(key, None, f"missing; {spec.expectation(annotation, table)}")
    if kind == "missing":
        places.pop()  # it is the list that is too short
    for place in places:
        entries = get_args(annotation)
        if isinstance(place, str):  # of a mapping, or the entry's key if that is refused
            key, value, annotation = f"{key}.{place}", error["input"], entries[-1]
        else:
            annotation = entries[0 if entries[-1] is Ellipsis else place]
            key, value = f"{key}[{place}]", value[place]
    cause = error.get("ctx", {}).get("error")
    if isinstance(cause, InvalidValue):  # of a section
        return cause.under(key)
    typed = kind.endswith(("_type", "_of")) or (not isinstance(value, str) and spec.choices)
    expected = spec.expectation(annotation, table)
    return (InvalidType if typed else InvalidValue)(key, value, expected)
