"""Formatting of messages."""


def join_lines(text: str) -> str:
    """Return a text as one line: its lines without surrounding blanks, joined by spaces."""
    return " ".join(filter(None, map(str.strip, text.splitlines())))
