"""Frozen dataclasses that check themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler
    from pydantic_core import CoreSchema


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

    # pydantic takes a tenth of a second to import, which help and completion need not wait for

    def __post_init__(self) -> None:
        from mgeo_attitude.fields.checking import checked_fields

        for name, value in checked_fields(self).items():
            object.__setattr__(self, name, value)  # the dataclass is frozen for everyone else

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        from mgeo_attitude.fields.checking import instance_schema, section_model

        return instance_schema(cls, [section_model(cls)], handler)
