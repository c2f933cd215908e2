"""Validation of whole files with pydantic models; the error message states the first mistake."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from mgeo.validation.arguments import format_suggestion

_STRICT = ConfigDict(strict=True, allow_inf_nan=False)


class Table(BaseModel):
    """Base class for pydantic models of files, with strict types and no unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, **_STRICT)

    @model_validator(mode="before")
    @classmethod
    def _check_keys(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        known = list(cls.model_fields)
        for key in data if cls.model_config["extra"] == "forbid" else ():
            if key not in known:
                expected = f"expected {', '.join(known)}{format_suggestion(key, known)}"
                raise PydanticCustomError("key", f"{key!s:.80} is unknown: {expected}")
        return data


T = TypeVar("T", bound=Table)


def validate_table(model: type[T], data: Any) -> T:
    """Validate the content of a file, and return an instance of a pydantic model.

    Parameters
    ----------
    model : type
        Subclass of `Table`.
    data : mapping
        Content of the file.

    Raises
    ------
    ValueError
        For the first mistake, with its place, such as ``problems[0].name``, value and expectation.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise ValueError(_describe_first_error(error)) from None


def format_expectation(message: str) -> str:
    """Rephrase an error message of pydantic so that it begins with "expected"."""
    for old, new in (
        ("Value error, ", ""),
        ("Input should be", "expected"),
        ("a valid integer", "an integer"),
        ("a valid ", "a "),
        ("greater than or equal to", "at least"),
        ("less than or equal to", "at most"),
    ):
        message = message.replace(old, new)
    return message.partition(" or instance")[0].partition(", unable to parse")[0].rstrip(".")


def _describe_first_error(validation_error: ValidationError) -> str:
    error = validation_error.errors()[0]
    parts = (f"[{key}]" if isinstance(key, int) else f".{key}" for key in error["loc"])
    where = "".join(parts).lstrip(".")
    if error["type"] == "missing":
        return f"{where} is missing"
    if error["type"] == "key":
        return f"{where}.{error['msg']}".lstrip(".")
    if error["type"] == "value_error":  # The messages of validators already state key and value.
        return str(error["ctx"]["error"])
    expected = format_expectation(error["msg"])
    value = "" if isinstance(error["input"], Mapping) else f" = {error['input']!r:.80}"
    return f"{where}{value}: {expected}"
