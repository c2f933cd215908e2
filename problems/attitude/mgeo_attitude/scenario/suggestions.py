"""What to say about a name that is not known."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def known_names(name: object, known: Iterable[str]) -> str:
    """``, did you mean 'x'? (known: 'x', 'y')``, the question only if a known name is close."""
    names = list(known)
    # the usual slip is a key without its unit: bias for bias_deg_s
    longer = [candidate for candidate in names if candidate.startswith(f"{name}_")]
    close = longer or get_close_matches(str(name), names, n=1)
    question = f", did you mean {' or '.join(map(repr, close))}?" if close else ""
    return f"{question} (known: {', '.join(map(repr, names))})"
