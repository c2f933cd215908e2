"""Frozen dataclasses that check themselves."""

from __future__ import annotations


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
        from .checking import checked_fields  # pydantic takes a tenth of a second

        for name, value in checked_fields(self).items():
            object.__setattr__(self, name, value)  # the dataclass is frozen for everyone else
