"""Frozen dataclasses that check themselves: sections as pydantic checks and describes them.

It takes a tenth of a second to import, which help and completion need not wait for.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import MISSING
from functools import partial
from types import NoneType, UnionType
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    Literal,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np

from mgeo_attitude.fields.quantity import (
    InvalidType,
    InvalidValue,
    Kinds,
    Quantity,
    declared,
    remembered,
)
from mgeo_attitude.fields.tables import flattened

if TYPE_CHECKING:
    import pydantic
    from pydantic import GetCoreSchemaHandler
    from pydantic_core import CoreSchema, ErrorDetails


class Validated:
    """Base of frozen dataclasses whose fields are checked by annotation and `quantity`.

    Understood annotations: float (takes any real number), int, bool, str, tuples of these (taking
    lists), classes, and any of these or None. A bool is never a number; numbers are finite; a range
    holds for every entry of a tuple. A subclass that checks more extends ``__post_init__``.

    Raises
    ------
    InvalidType, InvalidValue
        (TypeError, ValueError) Naming the field, its value and what was expected.
    """

    def __post_init__(self) -> None:
        for name, value in checked_fields(self).items():
            object.__setattr__(self, name, value)  # the dataclass is frozen for everyone else

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return instance_schema(cls, [section_model(cls)], handler)


def checked_fields(section: Any) -> dict[str, Any]:
    """The fields of a section as their annotations want them: an int as float, a list as tuple."""
    from pydantic import ValidationError

    given = {name: getattr(section, name) for name in declared(type(section))}
    plain = {name: _plain(value) for name, value in given.items()}
    try:
        read = section_model(type(section)).model_validate(plain)
    except ValidationError as error:
        raise _in_words(error.errors(include_url=False)[0], section) from None
    return {name: getattr(read, name) for name in given}


@remembered
def section_model(cls: Any, key: str = "", names: tuple[str, ...] = ()) -> type[pydantic.BaseModel]:
    """The pydantic model of a section's fields, with `key`, one of `names`, before them."""
    import pydantic

    hints = get_type_hints(cls, include_extras=True)
    specs = declared(cls)
    unsaid: dict[str, Any] = {"default_factory": lambda: None}  # a schema shows no default
    entries: dict[str, Any] = {key: (Literal[names], pydantic.Field(**unsaid))} if key else {}
    for field in dataclasses.fields(cls):
        spec = specs[field.name][1]
        text = f"{spec.doc} [{spec.unit}]" if spec.unit else spec.doc
        required = field.default is field.default_factory is MISSING
        shown = {"default": field.default} if field.default not in (None, MISSING) else unsaid
        info = pydantic.Field(description=text or None, **({} if required else shown))
        entries[field.name] = (_checked_type(hints[field.name], spec), info)
    config = pydantic.ConfigDict(
        strict=True,
        extra="forbid",
        allow_inf_nan=False,
        arbitrary_types_allowed=True,
        field_title_generator=lambda name, info: name,
    )
    return pydantic.create_model(cls.__name__, __config__=config, **entries)


def instance_schema(
    classes: Any, models: Sequence[type[pydantic.BaseModel]], handler: GetCoreSchemaHandler
) -> CoreSchema:
    """In Python an instance of some classes, in JSON what one of the models says."""
    from pydantic_core import core_schema

    return core_schema.json_or_python_schema(
        core_schema.union_schema([handler.generate_schema(model) for model in models]),
        core_schema.is_instance_schema(classes),
    )


def _checked_type(hint: Any, spec: Quantity) -> Any:
    """A field's annotation as pydantic shall check it: bounds hold for each number in it."""
    import pydantic

    entries = get_args(hint)
    if get_origin(hint) is tuple:
        return tuple[tuple(e if e is Ellipsis else _checked_type(e, spec) for e in entries)]  # type: ignore[misc]
    if any(get_origin(entry) is tuple for entry in entries):  # or None, or one number for all
        kinds = (e if e is NoneType else _checked_type(e, spec) for e in entries)
        return Union[tuple(kinds)]  # noqa: UP007
    if get_origin(hint) is Annotated:  # Mapping[str, float], made a subclass of Numbers
        number: Any = _checked_type(float, spec)
        nested = dict[str, number | dict[str, number]]
        flat = pydantic.BeforeValidator(flattened, json_schema_input_type=nested)
        return Annotated[dict[str, number], flat, pydantic.AfterValidator(entries[1])]
    if spec.kinds:
        return Annotated[hint, pydantic.GetPydanticSchema(partial(_kinds_schema, kinds=spec.kinds))]
    if spec.choices:
        allowed: Any = Literal[spec.choices]
        return allowed | None if NoneType in entries else allowed
    return Annotated[hint, pydantic.Field(**spec.bounds())] if spec.bounds() else hint


def _kinds_schema(hint: Any, handler: GetCoreSchemaHandler, kinds: Kinds) -> CoreSchema:
    names: dict[Any, tuple[str, ...]] = {}
    for name, cls in kinds.classes.items():
        names[cls] = (*names.get(cls, ()), name)
    models = [section_model(cls, kinds.key, own) for cls, own in names.items()]
    return instance_schema((hint, *names), models, handler)


def _plain(value: Any) -> Any:
    """Numbers of numpy as Python's, and lists as tuples: all else is taken as it is or refused."""
    if isinstance(value, list | tuple):
        return tuple(map(_plain, value))
    return value.item() if isinstance(value, np.generic) else value


def _in_words(error: ErrorDetails, section: Any) -> InvalidValue:
    """What pydantic refuses, in the words of the field: key, value, and what was expected."""
    kind, (key, *places) = error["type"], error["loc"]
    annotation, spec = declared(type(section))[str(key)]
    value = getattr(section, str(key))
    if kind == "missing":
        places.pop()  # it is the list that is too short
    for place in places:
        if get_origin(annotation) in (Union, UnionType):  # with None, which has no places
            several = [kind for kind in get_args(annotation) if kind is not NoneType]
            if len(several) > 1:  # a number or a tuple of them: of neither is it a place
                kind = "value"
                break
            (annotation,) = several
        entries = get_args(annotation)
        if isinstance(place, str):  # of a mapping, or the entry's key if that is refused
            key, value, annotation = f"{key}.{place}", error["input"], entries[-1]
        else:
            if entries[-1] is NoneType:
                entries = get_args(entries[0])
            annotation = entries[0 if entries[-1] is Ellipsis else place]
            key, value = f"{key}[{place}]", value[place]
    cause = error.get("ctx", {}).get("error")
    if isinstance(cause, InvalidValue):
        return cause.under(str(key))
    typed = kind.endswith(("_type", "_of")) or (not isinstance(value, str) and spec.choices)
    return (InvalidType if typed else InvalidValue)(str(key), value, spec.expectation(annotation))
