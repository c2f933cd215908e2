"""Formatting of messages."""


def join_lines(text: str) -> str:
    """Join the lines of a text by spaces, without surrounding blanks and empty lines."""
    return " ".join(filter(None, map(str.strip, text.splitlines())))
