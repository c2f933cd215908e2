"""Formatting of text for messages."""


def join_lines(text: str) -> str:
    """Join the stripped lines of a text with spaces, without empty lines."""
    return " ".join(filter(None, map(str.strip, text.splitlines())))
