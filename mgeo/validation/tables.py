"""Tables that files hold as pydantic models, with one error that names the first mistake."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from mgeo.validation.arguments import did_you_mean

_STRICT = ConfigDict(strict=True, allow_inf_nan=False)


class Table(BaseModel):
    """A table whose keys are known, and whose values are taken as they are or refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, **_STRICT)

    @model_validator(mode="before")
    @classmethod
    def _check_keys(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        known = list(cls.model_fields)
        for key in data if cls.model_config["extra"] == "forbid" else ():
            if key not in known:
                expected = f"expected {', '.join(known)}{did_you_mean(key, known)}"
                raise PydanticCustomError("key", f"{key!s:.80} is unknown: {expected}")
        return data


T = TypeVar("T", bound=Table)


def checked(model: type[T], data: Any) -> T:
    """A table that was read, as its model.

    Raises
    ------
    ValueError
        Naming the first thing that is wrong: its place, as ``problems[0].name``, its value and
        what was expected.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise ValueError(_in_words(error)) from None


def _in_words(caught: ValidationError) -> str:
    """Return the first error in words."""
    error = caught.errors()[0]
    places = (f"[{key}]" if isinstance(key, int) else f".{key}" for key in error["loc"])
    where = "".join(places).lstrip(".")
    if error["type"] == "missing":
        return f"{where} is missing"
    if error["type"] == "key":
        return f"{where}.{error['msg']}".lstrip(".")
    if error["type"] == "value_error":  # of functions whose messages name key and value
        return str(error["ctx"]["error"])
    expected = error["msg"].replace("Input should be", "expected").partition(" or instance")[0]
    value = "" if isinstance(error["input"], Mapping) else f" = {error['input']!r:.80}"
    return f"{where}{value}: {expected}"
