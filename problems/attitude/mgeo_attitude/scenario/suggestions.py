"""What to say about a name that is not known."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def known_names(name: object, known: Iterable[str]) -> str:
    """``did you mean 'x'? Known: 'x', 'y'``, the question only if some known name is close."""
    names = list(known)
    close = get_close_matches(str(name), names, n=1)
    question = f"did you mean {close[0]!r}? " if close else ""
    return f"{question}Known: {', '.join(map(repr, names))}"
