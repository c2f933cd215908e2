"""Formatting of messages."""


def join_lines(text: str) -> str:
    """Join the nonempty lines of a text by spaces, after stripping each line."""
    return " ".join(filter(None, map(str.strip, text.splitlines())))
