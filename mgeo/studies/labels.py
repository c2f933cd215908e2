"""Labels of problems and algorithms of a study, and the folders of its problems."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from typing import Any

_LONGEST = 60  # characters of a folder's name, but for what makes it unique
_TAKEN = ("runs",)  # what else is in a study's folder


def filled(text: str, where: str, values: Mapping[str, Any]) -> str:
    """Fill a ``label``, in which ``{name}`` stands for the value of that name.

    Raises
    ------
    ValueError
        If there is anything else in braces.
    """
    # not str.format, which looks into objects: {name.__class__}, {name:>999999999}
    parts = re.split(r"\{(\w+)\}", text)
    if any("{" in part or "}" in part for part in parts[::2]) or set(parts[1::2]) - set(values):
        raise ValueError(
            f"{where}label = {text!r:.80}: expected text in which braces hold only "
            f"{', '.join(values)}"
        )
    parts[1::2] = (str(values[key]) for key in parts[1::2])
    return "".join(parts)


def folder_name(label: str) -> str:
    """Return the name of a label's folder; different labels have different folders.

    Of a label of lower-case words, digits and underscores it is these words with hyphens between
    them. Of any other the rest is left out, and ``~`` and eight hexadecimal digits tell it from
    those that look like it.
    """
    plain = re.fullmatch(r"[a-z0-9_]+( [a-z0-9_]+)*", label) and len(label) <= _LONGEST
    if plain and label not in _TAKEN:
        return label.replace(" ", "-")
    readable = re.sub(r"[\W-]+", "-", label.lower())[:_LONGEST].strip("-") or "problem"
    return f"{readable}~{hashlib.sha256(label.encode()).hexdigest()[:8]}"
