"""Messages of others on one line."""


def one_line(text: str) -> str:
    """The lines of a text, without blanks at their ends, on one line.

    Blanks within a line stay: a value that a message quotes may be told by its columns.
    """
    return " ".join(filter(None, map(str.strip, text.splitlines())))
